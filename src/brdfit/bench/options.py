"""What every benchmark may be told on the command line, and how it talks back."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from brdfit.bench.ledger import Ledger

__all__ = ["Say", "add_run_arguments", "ledger_of", "share"]

Say = Callable[[str], None]
"""Where a benchmark says something to a person; the command line prints it."""


def add_run_arguments(parser: argparse.ArgumentParser, result: str) -> None:
    """Add the output, the seed and what governs the execution."""
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path(result),
        metavar="RESULT",
        help=f"result file; tables and figures go beside it (default: {result})",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of all choices (default: 1)")
    parser.add_argument(
        "--restart", action="store_true", help="throw an earlier run away instead of continuing it"
    )
    parser.add_argument(
        "--workers",
        type=int,
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes (default: one per core); does not change the result",
    )


def ledger_of(arguments: argparse.Namespace, header: dict[str, object]) -> Ledger:
    """Return the ledger that the common arguments describe."""
    return Ledger(arguments.output, header, arguments.restart, max(arguments.workers, 1))


def share(text: str) -> float:
    """Read a number between 0 and 1, both excluded, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"found {text!r} but expected a number between 0 and 1")
    return value
