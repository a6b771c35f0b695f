"""`brdfit convert`: one format in, another out, and what that loses."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.cli.writing import add_output_format
from brdfit.errors import BrdfitError, UsageError

if TYPE_CHECKING:
    from brdfit.report.conversion import Converted
    from brdfit.report.reading import Kind
    from brdfit.samples import Samples
    from brdfit.table import Table


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit convert` takes."""
    parser.add_argument("input", type=Path, metavar="IN", help="File of samples or a table.")
    parser.add_argument(
        "output", type=Path, metavar="OUT", help="File to write; the suffix says the format."
    )
    add_output_format(parser)
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        help="What to convert, where both formats can hold both.",
    )
    parser.add_argument(
        "--json", action="store_true", help="Print what was kept and what was lost as JSON."
    )
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read one file, write the other, say what was lost."""
    from brdfit.formats import format_to_write, rivals
    from brdfit.report.conversion import convert
    from brdfit.samples import Samples

    source, target = arguments.input, arguments.output
    sheet = format_to_write(target, format=arguments.to)
    _check_target(source, target)
    first: Kind = arguments.kind or ("table" if sheet.write_table is not None else "samples")
    content = _read(source, reading_options(arguments), first, target)
    kind = "samples" if isinstance(content, Samples) else "table"
    if arguments.kind not in (None, kind):
        raise UsageError(f"{source.name}: holds {kind}, not {arguments.kind}.")
    converted = convert(content, source, target, sheet)
    if arguments.json:
        console.result(json.dumps(_record(converted, arguments, console), indent=1))
        return
    others = rivals(sheet, target) if arguments.to is None else ()
    hint = f"; --to {' or '.join(others)} writes another {target.suffix}" if others else ""
    for note in converted.notes:
        console.remark(f"  {'read':<11} {note}")
    for loss in converted.losses:
        console.remark(f"  {loss.aspect:<11} {'LOST ' if loss.lost else ''}{loss.sentence}")
    console.say(f"wrote {target} ({kind}, {sheet.name}{hint})")


def _record(
    converted: Converted, arguments: argparse.Namespace, console: Console
) -> dict[str, Any]:
    from brdfit.files import sha256_of_file

    source, target = arguments.input, arguments.output
    return {
        "schema": "brdfit.convert/1",
        "input": {"name": source.name, "sha256": sha256_of_file(source)},
        "output": {"name": target.name, "sha256": sha256_of_file(target)},
        **converted.record(),
        "warnings": list(console.warnings),
    }


def _read(source: Path, options: dict[str, Any], first: Kind, target: Path) -> Samples | Table:
    from brdfit.formats import list_formats
    from brdfit.report.reading import read_any

    try:
        return read_any(source, options, first)
    except BrdfitError as error:
        # --format is of the input; who typed it for the output finds the other option
        named = next((s for s in list_formats() if s.name == options.get("format")), None)
        if named is None or target.suffix.lower() not in named.extensions:
            raise
        raise UsageError(
            f"{error} (--format is of the input; for the output: --to {named.name})"
        ) from error


def _check_target(source: Path, target: Path) -> None:
    if target.resolve() == source.resolve():
        raise UsageError(f"{target}: is the input; the output must be another file.")
    if not target.parent.is_dir():
        raise UsageError(f"{target}: the folder {str(target.parent)!r} does not exist.")
