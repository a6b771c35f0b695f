"""`brdfit compare`: how far one BRDF is from another."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser

if TYPE_CHECKING:
    from brdfit.report.compare import Comparison


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit compare` takes."""
    from brdfit.render import ILLUMINATIONS

    parser.add_argument(
        "reference", type=Path, metavar="REFERENCE", help="Table or samples that are trusted."
    )
    parser.add_argument("test", type=Path, metavar="TEST", help="Table to be judged.")
    parser.add_argument("--json", action="store_true", help="Print JSON, for scripts.")
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        default="table",
        help="What the reference is, if it can be read as both (default: table).",
    )
    parser.add_argument(
        "--illumination",
        action="append",
        choices=list(ILLUMINATIONS),
        help="Light to render under; may be repeated (default: studio and point).",
    )
    parser.add_argument(
        "--size", type=int, default=64, metavar="PIXELS", help="Edge of the spheres (default: 64)."
    )
    add_reading_options(parser, "reading the reference")


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read both, compare, print."""
    from brdfit.report.compare import compare
    from brdfit.report.reading import read_any, read_table_of

    reference = read_any(arguments.reference, reading_options(arguments), arguments.kind)
    test = read_table_of(arguments.test)
    with console.progress() as progress:
        comparison = compare(
            reference,
            test,
            illuminations=arguments.illumination or ("studio", "point"),
            size=arguments.size,
            progress=progress,
        )
    if arguments.json:
        record = {
            "schema": "brdfit.compare/1",
            "reference": arguments.reference.name,
            "test": arguments.test.name,
            **comparison.to_dict(),
            "warnings": list(console.warnings),
        }
        console.result(json.dumps(record, indent=1))
    else:
        console.result("\n".join(_lines(comparison)))


def _lines(comparison: Comparison) -> list[str]:
    from brdfit.metrics import METRICS

    lines = []
    for light, found in comparison.images.items():
        lines.append(f"sphere of {comparison.sphere_size} pixels under {light}")
        lines += [
            f"  {name:<18} {value:.4g} {METRICS[name].unit}".rstrip()
            for name, value in found.items()
        ]
    lines.append(f"values at {comparison.directions} directions ({', '.join(comparison.channels)})")
    for name, score in comparison.values.items():
        skipped = f" ({score.skipped} skipped)" if score.skipped else ""
        lines.append(f"  {name:<18} {score.value:.4g} {METRICS[name].unit}".rstrip() + skipped)
    lines += [f"note: {note}" for note in comparison.notes]
    lines += [f"absent: {name}: {why}" for name, why in comparison.absent.items()]
    return lines
