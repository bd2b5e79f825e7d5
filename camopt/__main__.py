"""``python -m camopt``: the command line."""

import sys

from camopt.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
