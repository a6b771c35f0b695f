"""Real files, a part fitted and the rest predicted: conditions, judgement, page.

`add_arguments` and `run` are what the command line needs.
"""

from __future__ import annotations

from brdfit.bench.holdout.command import HELP, add_arguments, run

__all__ = ["HELP", "add_arguments", "run"]
