"""``camopt`` and ``python -m camopt``: the command line."""

import gc
import os
import sys

from camopt.cli.interrupts import exit_code_of_interrupt, is_interrupted, raise_keyboard_interrupt_on_signals

OBJECTS_BETWEEN = 150_000
"""New objects between searches for garbage: imports make 100,000 that stay, and a search every 700 takes a tenth of
a command."""


def main() -> int:
    """Run a command; the exit code. An interrupt is told as one from the first import on."""
    with raise_keyboard_interrupt_on_signals():
        try:
            gc.set_threshold(OBJECTS_BETWEEN)
            os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # it would look through all packages
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small: threads wait for each other
            from camopt.cli.main import main as run

            return run()
        except BaseException as end:
            if not (
                isinstance(end, KeyboardInterrupt) or is_interrupted()
            ):  # imports make other errors of interrupts
                raise
            print("camopt: interrupted", file=sys.stderr)
            return exit_code_of_interrupt()
        finally:
            gc.freeze()  # at its end the interpreter need not search all objects for garbage


if __name__ == "__main__":
    sys.exit(main())
