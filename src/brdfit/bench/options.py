"""What every benchmark may be told on the command line, and how it talks back."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from brdfit.bench.ledger import Ledger, read_result
from brdfit.errors import UsageError
from brdfit.files import atomic_path

__all__ = ["Say", "add_run_arguments", "ledger_of", "result_of", "share", "write_page"]

Say = Callable[[str], None]
"""Where a benchmark says something to a person; the command line prints it."""


def add_run_arguments(parser: argparse.ArgumentParser, result: str, workers: bool = True) -> None:
    """Add the output, the seed, what governs the execution, and the page alone.

    `workers` is False where parts that run side by side would spoil the result.
    """
    parser.add_argument(
        "--from-result",
        action="store_true",
        help="compute nothing: make the page again from RESULT as it is",
    )
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
    if workers:
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


def result_of(path: Path, benchmark: str) -> dict[str, Any]:
    """Return the content of a result file of `benchmark`.

    Raises `UsageError` if it is another's, `CorruptFile` if it is no result at all.
    """
    content = read_result(path)
    if content.get("benchmark") != benchmark:
        raise UsageError(f"{path}: this is not a result of `brdfit bench {benchmark}`.")
    return content


def write_page(path: Path, benchmark: str, page: Callable[[dict[str, Any]], str], say: Say) -> None:
    """Write the page of the result file `path` beside it, whole or not at all.

    Raises `UsageError` if the result lacks what the page tells, as one of an earlier version.
    """
    content = result_of(path, benchmark)
    try:
        text = page(content)
    except KeyError as error:
        raise UsageError(
            f"{path}: found no {error} but the page tells of it; this result was written by "
            f"another version of `brdfit bench {benchmark}`. Run the benchmark again."
        ) from error
    target = path.with_suffix(".md")
    with atomic_path(target) as aside:
        aside.write_text(text, encoding="utf-8")
    say(f"wrote {path} and {target}")


def share(text: str) -> float:
    """Read a number between 0 and 1, both excluded, for argparse."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"found {text!r} but expected a number between 0 and 1")
    return value
