"""`python -m brdfit`."""

from __future__ import annotations

import sys

from brdfit.cli import main

if __name__ == "__main__":
    sys.exit(main())
