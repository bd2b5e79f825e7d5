"""``camopt`` and ``python -m camopt``: the command line."""

import os
import sys

from camopt.cli.interrupts import code, interrupts


def main() -> int:
    """Run a command; the exit code. An interrupt is told as one from the first import on."""
    with interrupts():
        try:
            os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # looked for among all installed packages
            from camopt.cli.main import main as run

            return run()
        except KeyboardInterrupt:
            print("camopt: interrupted", file=sys.stderr)
            return code()


if __name__ == "__main__":
    sys.exit(main())
