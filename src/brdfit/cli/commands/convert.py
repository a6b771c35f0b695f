"""`brdfit convert`: one format in, another out; the content stays."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.formats import FormatSheet
    from brdfit.report.reading import Kind
    from brdfit.table import Table


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit convert` takes."""
    parser.add_argument("input", type=Path, metavar="IN", help="File of samples or a table.")
    parser.add_argument(
        "output", type=Path, metavar="OUT", help="File to write; the suffix says the format."
    )
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        help="What to convert, where both formats can hold both.",
    )
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read one file, write the other, say what was lost."""
    from brdfit.formats import write_samples, write_table
    from brdfit.report.reading import read_any
    from brdfit.samples import Samples

    source, target = arguments.input, arguments.output
    sheet = _sheet_of(target)
    _check_target(source, target)
    first: Kind = arguments.kind or ("table" if sheet.write_table is not None else "samples")
    content = read_any(source, reading_options(arguments), first)
    kind = "samples" if isinstance(content, Samples) else "table"
    if arguments.kind not in (None, kind):
        raise UsageError(f"{source.name}: holds {kind}, not {arguments.kind}.")
    if isinstance(content, Samples):
        if sheet.write_samples is None:
            raise UsageError(
                f"{target.name}: {sheet.title} holds a complete table, but {source.name} holds "
                f"{len(content)} samples. To make a table of them: brdfit fit {source} -o {target}"
            )
        write_samples(content, target)
    else:
        if sheet.write_table is None:
            raise UsageError(
                f"{target.name}: {sheet.title} holds samples, but {source.name} holds a table. To "
                f"sample it at directions of your own: brdfit evaluate {source} --at DIRECTIONS.csv"
            )
        write_table(_fitting(content, sheet, console), target)
    console.say(f"wrote {target} ({kind}, {sheet.name})")


def _fitting(table: Table, sheet: FormatSheet, console: Console) -> Table:
    if sheet.name != "merl":
        return table
    from brdfit.report.rgb import rgb_table

    rgb, conversion = rgb_table(table)
    if conversion.kind != "none":
        console.say(f"  channels    {conversion}")
    return rgb


def _sheet_of(target: Path) -> FormatSheet:
    from brdfit.formats import list_formats

    able = [s for s in list_formats() if s.write_table is not None or s.write_samples is not None]
    for sheet in able:
        if target.suffix.lower() in sheet.extensions:
            return sheet
    known = ", ".join(f"{' '.join(sheet.extensions)} ({sheet.title})" for sheet in able)
    raise UsageError(
        f"{target.name}: the suffix {target.suffix!r} names no format that can be written. "
        f"There are: {known}."
    )


def _check_target(source: Path, target: Path) -> None:
    if target.resolve() == source.resolve():
        raise UsageError(f"{target}: is the input; the output must be another file.")
    if not target.parent.is_dir():
        raise UsageError(f"{target}: the folder {str(target.parent)!r} does not exist.")
