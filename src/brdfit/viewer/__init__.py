"""A page in the browser for tables and reconstructions: `brdfit view`.

messages    what server and page say to each other
"""

from __future__ import annotations
