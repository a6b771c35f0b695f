"""`brdfit render`: a table as a sphere."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import UsageError


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit render` takes."""
    from brdfit.render import ILLUMINATIONS

    parser.add_argument("file", type=Path, metavar="FILE", help="Table to look at.")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="PNG", help="Picture to write."
    )
    parser.add_argument(
        "--illumination",
        choices=list(ILLUMINATIONS),
        default="area_studio",
        help="Light (default: area_studio).",
    )
    parser.add_argument(
        "--size", type=int, default=256, metavar="PIXELS", help="Edge length (default: 256)."
    )
    parser.add_argument(
        "--exposure",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="Brighten by this factor, after the 95th percentile was brought to 0.8.",
    )
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the table, shade the sphere, write the picture."""
    from brdfit.formats import read_table
    from brdfit.render import ILLUMINATIONS, Sphere
    from brdfit.report.picture import write_picture
    from brdfit.report.rgb import rgb_table
    from brdfit.tone import display_image, exposure_scale

    if arguments.output.suffix.lower() != ".png":
        raise UsageError(f"{arguments.output}: pictures are written as .png.")
    table = read_table(arguments.file, **reading_options(arguments))
    rgb, conversion = rgb_table(table)
    if conversion.kind != "none":
        console.say(f"  channels    {conversion}")
    sphere = Sphere(arguments.size)
    linear = sphere.shade(rgb, ILLUMINATIONS[arguments.illumination]())
    scale = exposure_scale(linear, sphere.mask) * arguments.exposure
    write_picture(display_image(linear, scale), arguments.output)
    console.say(f"wrote {arguments.output} (sphere under {arguments.illumination})")
