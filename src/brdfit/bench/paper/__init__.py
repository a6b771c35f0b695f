"""The poster's tables: settings, shared scene, contenders, tables, figures, page.

`add_arguments` and `run` are what the command line needs.
"""

from __future__ import annotations

from brdfit.bench.paper.command import HELP, add_arguments, run

__all__ = ["HELP", "add_arguments", "run"]
