"""`python -m comotion`: the same as the command `comotion`."""

import sys

from comotion.main import main

if __name__ == "__main__":
    sys.exit(main())
