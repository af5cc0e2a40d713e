"""``python -m tool0`` is ``tool0``."""

import sys

from tool0.cli import main

if __name__ == "__main__":
    sys.exit(main())
