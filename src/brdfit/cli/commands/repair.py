"""`brdfit repair`: what can be put right is put right, and every change is listed."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.cli.writing import add_output_format
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.physics import Repair
    from brdfit.report.reading import Kind
    from brdfit.samples import Samples
    from brdfit.table import Table


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit repair` takes."""
    parser.add_argument("input", type=Path, metavar="IN", help="File of samples or a table.")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="OUT", help="File to write."
    )
    add_output_format(parser)
    parser.add_argument("--json", action="store_true", help="Print the changes as JSON.")
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        default="table",
        help="Which to read, from a format that can be read as both (default: table).",
    )
    group = parser.add_argument_group(
        "what is put right in a table",
        "Always: a negative value is taken for missing, in its channel. In samples: the values of "
        "exchanged light and detector are averaged.",
    )
    group.add_argument(
        "--keep-missing", action="store_true", help="Leave cells missing that nobody measured."
    )
    group.add_argument(
        "--symmetrize", action="store_true", help="Average phi_d and -phi_d (default: leave both)."
    )
    group.add_argument(
        "--limit",
        type=float,
        default=1.0,
        metavar="ALBEDO",
        help="Largest directional albedo; values give way until it is kept, doubtful ones first "
        "(default: 1).",
    )
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read, repair, write, tell."""
    from brdfit.files import sha256_of_file
    from brdfit.formats import format_to_write, write_samples, write_table
    from brdfit.report.reading import read_any
    from brdfit.samples import Samples

    if arguments.output.resolve() == arguments.input.resolve():
        raise UsageError(f"{arguments.output}: is the input; the output must be another file.")
    # before any work: is there a format, and can it hold what is read?
    format_to_write(arguments.output, format=arguments.to)
    content = read_any(arguments.input, reading_options(arguments), arguments.kind)
    kind: Kind = "samples" if isinstance(content, Samples) else "table"
    format_to_write(arguments.output, format=arguments.to, kind=kind)
    repair = _repaired(content, arguments)
    if isinstance(repair.content, Samples):
        write_samples(repair.content, arguments.output, format=arguments.to)
    else:
        write_table(repair.content, arguments.output, format=arguments.to)
    if arguments.json:
        record = {
            "schema": "brdfit.repair/1",
            "input": {"name": content.source.name, "sha256": sha256_of_file(arguments.input)},
            "output": arguments.output.name,
            **repair.record(),
            "warnings": list(console.warnings),
        }
        console.result(json.dumps(record, indent=1))
        return
    for change in repair.changes:
        console.say(f"  {change.name:<11} {change.sentence}")
    console.say(f"wrote {arguments.output} ({repair.changed} of {len(repair.changes)} changed it)")


def _repaired(content: Samples | Table, arguments: argparse.Namespace) -> Repair:
    from brdfit.physics import repair_samples, repair_table
    from brdfit.samples import Samples

    if isinstance(content, Samples):
        return repair_samples(content)
    return repair_table(
        content,
        fill=not arguments.keep_missing,
        symmetrize=arguments.symmetrize,
        limit=arguments.limit,
    )
