"""`brdfit render`: tables as spheres, one a picture or many on a sheet."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.arrays import FloatArray
    from brdfit.progress import Progress
    from brdfit.render import Environment, Illumination, Sphere
    from brdfit.table import Table

    Shader = Callable[[Table, Progress], FloatArray]

_SAMPLES = {"brdfit": 128, "mitsuba": 256}


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit render` takes."""
    parser.add_argument(
        "files", type=Path, nargs="+", metavar="FILE", help="Table to look at; many with --sheet."
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="PNG", help="Picture to write (--sheet: sheet.png)."
    )
    _add_light(parser)
    _add_renderer(parser)
    _add_picture(parser)
    add_reading_options(parser)


def _add_light(parser: Parser) -> None:
    from brdfit.render import ILLUMINATIONS

    light = parser.add_mutually_exclusive_group()
    light.add_argument(
        "--illumination",
        choices=list(ILLUMINATIONS),
        default="area_studio",
        help="Light (default: area_studio).",
    )
    light.add_argument(
        "--environment",
        type=Path,
        metavar="MAP",
        help="Light from a panorama, .exr or .hdr, equirectangular: top row up, middle column "
        "behind the sphere.",
    )
    parser.add_argument(
        "--rotate",
        type=float,
        default=0.0,
        metavar="DEGREES",
        help="Turn the panorama to the right about the vertical.",
    )


def _add_renderer(parser: Parser) -> None:
    parser.add_argument(
        "--renderer",
        choices=list(_SAMPLES),
        default="brdfit",
        help="Who renders: brdfit itself (default), or Mitsuba 3 with our plugin, which needs the "
        "extra 'mitsuba' and the shared library of LLVM.",
    )
    parser.add_argument(
        "--samples",
        type=int,
        metavar="N",
        help=f"Directions per pixel under a panorama (default: {_SAMPLES['brdfit']}); with "
        f"--renderer mitsuba rays per pixel under any light (default: {_SAMPLES['mitsuba']}).",
    )


def _add_picture(parser: Parser) -> None:
    parser.add_argument(
        "--sheet", action="store_true", help="Put all FILEs on one sheet, with their names."
    )
    parser.add_argument(
        "--columns", type=int, metavar="N", help="Spheres in a row of the sheet (default: square)."
    )
    parser.add_argument(
        "--size",
        type=int,
        metavar="PIXELS",
        help="Edge length of a sphere (default: 256; on a sheet 128).",
    )
    parser.add_argument(
        "--exposure",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="Brighten by this factor, after the 95th percentile of each sphere was brought to "
        "0.8.",
    )


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the tables, shade the spheres, write the picture."""
    from brdfit.render import Sphere
    from brdfit.report.contact_sheet import write_contact_sheet
    from brdfit.report.picture import write_picture
    from brdfit.tone import display_image, exposure_scale

    output = _checked(arguments)
    sphere = Sphere(arguments.size or (128 if arguments.sheet else 256))
    shade, light = _shader(arguments, sphere)
    pictures = []
    with console.progress() as progress:
        for file in arguments.files:
            linear = shade(_table(file, arguments, console), progress)
            scale = exposure_scale(linear, sphere.mask) * arguments.exposure
            pictures.append((file.stem, display_image(linear, scale)))
    if arguments.sheet:
        write_contact_sheet(pictures, output, arguments.columns)
        console.say(f"wrote {output} ({len(pictures)} spheres under {light})")
    else:
        write_picture(pictures[0][1], output)
        console.say(f"wrote {output} (sphere under {light})")


def _checked(arguments: argparse.Namespace) -> Path:
    """Return where the picture goes."""
    if len(arguments.files) > 1 and not arguments.sheet:
        raise UsageError(
            f"found {len(arguments.files)} files but one picture shows one sphere. Add --sheet to "
            f"put all on one."
        )
    if arguments.columns is not None and arguments.columns < 1:
        raise UsageError(f"--columns: found {arguments.columns} but a row needs at least 1.")
    if arguments.samples is not None and arguments.samples < 2:
        raise UsageError(f"--samples: found {arguments.samples} but a pixel needs 2 or more.")
    if not (arguments.exposure > 0.0):
        raise UsageError(f"--exposure: found {arguments.exposure:g} but a factor is above 0.")
    if arguments.output is None and not arguments.sheet:
        raise UsageError("name the picture to write: -o PICTURE.png")
    output: Path = arguments.output or Path("sheet.png")
    if output.suffix.lower() != ".png":
        raise UsageError(f"{output}: pictures are written as .png.")
    if not output.parent.is_dir():
        raise UsageError(f"{output}: the folder {str(output.parent)!r} does not exist.")
    return output


def _shader(arguments: argparse.Namespace, sphere: Sphere) -> tuple[Shader, str]:
    """Return (table -> linear image, name of the light and of a renderer that is not ours)."""
    from brdfit.render import ILLUMINATIONS, Environment, shade_under
    from brdfit.report.environment_file import read_environment

    samples = arguments.samples or _SAMPLES[arguments.renderer]
    light: Environment | Illumination
    if arguments.environment is None:
        light = ILLUMINATIONS[arguments.illumination]()
    else:
        light = read_environment(arguments.environment, arguments.rotate)
    if arguments.renderer == "mitsuba":
        return _by_mitsuba(light, sphere.size, samples)
    if isinstance(light, Environment):
        return (
            lambda table, progress: shade_under(sphere, table, light, samples, progress)
        ), light.name
    return (lambda table, progress: sphere.shade(table, light, progress)), light.name


def _by_mitsuba(light: Environment | Illumination, size: int, samples: int) -> tuple[Shader, str]:
    from brdfit.mitsuba import bsdf
    from brdfit.mitsuba.library import mitsuba_library, require_llvm
    from brdfit.mitsuba.sphere import render_sphere

    require_llvm()

    def shade(table: Table, progress: Progress) -> FloatArray:
        return render_sphere(lambda: bsdf(table), light, size, samples, progress=progress)

    version = mitsuba_library().__version__
    return shade, f"{light.name}, by Mitsuba {version} with {samples} rays per pixel"


def _table(file: Path, arguments: argparse.Namespace, console: Console) -> Table:
    from brdfit.report.reading import read_table_of
    from brdfit.report.rgb import rgb_table

    rgb, conversion = rgb_table(read_table_of(file, **reading_options(arguments)))
    if conversion.kind != "none":
        console.say(f"  {file.name}: {conversion}")
    return rgb
