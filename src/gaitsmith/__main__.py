"""``python -m gaitsmith`` is the command ``gaitsmith``."""

import sys

from gaitsmith.cli import main

if __name__ == "__main__":
    sys.exit(main())
