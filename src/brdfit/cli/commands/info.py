"""`brdfit info`: what is in a file."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import CorruptFile, UsageError

if TYPE_CHECKING:
    from brdfit.physics import Health
    from brdfit.samples import Samples
    from brdfit.table import Table


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit info` takes."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="File of samples, a table, or the record of a fit.",
    )
    parser.add_argument("--json", action="store_true", help="Print JSON, for scripts.")
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        default="table",
        help="Which to read, from a format that can be read as both (default: table).",
    )
    parser.add_argument(
        "--physics",
        action="store_true",
        help="Check reciprocity, energy, noise near grazing, symmetry and alignment: for each a "
        "figure, a verdict and a sentence.",
    )
    parser.add_argument(
        "--picture",
        type=Path,
        metavar="PNG",
        help="With --physics: draw the directional albedo over incidence and the findings.",
    )
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the file and describe it."""
    from brdfit.report.fit_files import kept_record

    _check_picture(arguments)
    kept = kept_record(arguments.file)
    if kept is None or arguments.physics:
        _tell_of_contents(arguments, console)
    else:
        _tell_of_a_fit(arguments, kept, console)


def _tell_of_a_fit(arguments: argparse.Namespace, record: dict[str, Any], console: Console) -> None:
    from brdfit.cli.fit_lines import kept_fit_lines

    if arguments.json:
        console.result(json.dumps(record, indent=1))
        return
    try:
        lines = kept_fit_lines(arguments.file.name, record)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        found = f"has no entry {error}" if isinstance(error, KeyError) else f"is damaged ({error})"
        raise CorruptFile(
            f"{arguments.file}: is the record of a fit but {found}. Fit again, or use the table "
            f"without it."
        ) from error
    console.result("\n".join(lines))


def _tell_of_contents(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.cli.summary import samples_lines, samples_record, table_lines, table_record
    from brdfit.report.albedo_curve import AlbedoCurve
    from brdfit.report.reading import read_any
    from brdfit.samples import Samples

    content = read_any(arguments.file, reading_options(arguments), arguments.kind)
    if isinstance(content, Samples):
        record, lines = samples_record(content), samples_lines(content)
    else:
        record, lines = table_record(content), table_lines(content)
        albedo = AlbedoCurve.of(content) if content.mask.any() else None
        record["albedo"] = None if albedo is None else albedo.record()
        if albedo is not None:
            lines.append(f"  albedo      {albedo}")
    if arguments.physics:
        health = _examined(content, arguments.picture)
        record["physics"] = health.record()
        lines += [f"  {f.name:<11} {f.verdict}: {f.sentence}" for f in health.findings]
    if arguments.json:
        record["warnings"] = list(console.warnings)
        console.result(json.dumps(record, indent=1))
    else:
        console.result("\n".join(lines))


def _check_picture(arguments: argparse.Namespace) -> None:
    picture = arguments.picture
    if picture is None:
        return
    if not arguments.physics:
        raise UsageError("--picture draws the findings of --physics: give both.")
    if picture.suffix.lower() != ".png":
        raise UsageError(f"{picture}: pictures are written as .png.")


def _examined(content: Samples | Table, picture: Path | None) -> Health:
    from brdfit.physics import examine

    health = examine(content)
    if picture is not None:
        from brdfit.report.physics_figure import draw_health

        draw_health(health, content.source.name, picture)
    return health
