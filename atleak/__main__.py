"""``python -m atleak`` is the same as ``atleak``."""

import sys

from atleak.cli import main

if __name__ == "__main__":
    sys.exit(main())
