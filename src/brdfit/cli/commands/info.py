"""`brdfit info`: what is in a file."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit info` takes."""
    parser.add_argument("file", type=Path, metavar="FILE", help="File of samples or a table.")
    parser.add_argument("--json", action="store_true", help="Print JSON, for scripts.")
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        default="table",
        help="Which to read, from a format that can be read as both (default: table).",
    )
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the file and describe it."""
    from brdfit.cli.reading import read_any
    from brdfit.cli.summary import samples_lines, samples_record, table_lines, table_record
    from brdfit.samples import Samples

    content = read_any(arguments.file, reading_options(arguments), arguments.kind)
    if isinstance(content, Samples):
        record, lines = samples_record(content), samples_lines(content)
    else:
        record, lines = table_record(content), table_lines(content)
    if arguments.json:
        record["warnings"] = list(console.warnings)
        console.result(json.dumps(record, indent=1))
    else:
        console.result("\n".join(lines))
