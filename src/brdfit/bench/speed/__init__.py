"""What each stage takes, in seconds, memory and multiples of the least that it can take.

`add_arguments` and `run` are what the command line needs.
"""

from __future__ import annotations

from brdfit.bench.speed.command import HELP, add_arguments, run

__all__ = ["HELP", "add_arguments", "run"]
