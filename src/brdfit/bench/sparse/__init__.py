"""Few samples of held-out materials: settings, cases, published figures, page.

`add_arguments` and `run` are what the command line needs.
"""

from __future__ import annotations

from brdfit.bench.sparse.command import HELP, add_arguments, run

__all__ = ["HELP", "add_arguments", "run"]
