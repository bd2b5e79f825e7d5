"""``camopt`` and ``python -m camopt``: the command line."""

import sys


def main() -> int:
    """Run a command; the exit code. An interrupt is told as one from the first import on."""
    try:
        from camopt.cli.main import main as run
    except KeyboardInterrupt:
        print("camopt: interrupted, nothing written", file=sys.stderr)
        return 130
    return run()


if __name__ == "__main__":
    sys.exit(main())
