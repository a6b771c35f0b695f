"""`brdfit export`: a table as the few parameters that renderers without tables take."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.export.fitting import Analytic
    from brdfit.export.outputs import Exported

# Above it a material looks like another one.
_NOTABLE = 3.0


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit export` takes."""
    parser.description = (
        "Fit the material parameters of a renderer to a table, and say what that costs. A dozen "
        "numbers cannot hold a measured BRDF: where a renderer takes tables, use brdfit convert."
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="Table to fit.")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT",
        help="File to write. .mtlx: MaterialX with an OpenPBR surface. .gltf: glTF 2.0, the "
        "metallic-roughness material with its extensions, on a sphere. .json: the parameters of "
        "GGX, glTF and OpenPBR, and their errors, for scripts.",
    )
    parser.add_argument("--json", action="store_true", help="Print the parameters as JSON.")
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the table, fit, write, say how close it is."""
    from brdfit.export import write_export
    from brdfit.export.outputs import target_of
    from brdfit.report.reading import read_any
    from brdfit.samples import Samples

    source, output = arguments.file, arguments.output
    target_of(output).require()
    if output.resolve() == source.resolve():
        raise UsageError(f"{output}: is the input; the output must be another file.")
    if not output.parent.is_dir():
        raise UsageError(f"{output}: the folder {str(output.parent)!r} does not exist.")
    content = read_any(source, reading_options(arguments), "table")
    if isinstance(content, Samples):
        table = source.with_suffix(".npz").name
        raise UsageError(
            f"{source.name}: holds {len(content)} samples, but a complete table is needed. Fit it "
            f"first: brdfit fit {source} -o {table}, then brdfit export {table} -o {output}"
        )
    with console.progress() as progress:
        exported = write_export(content, output, progress=progress)
    if arguments.json:
        console.result(json.dumps(_record(exported, console), indent=1))
        return
    _tell(exported, console)


def _record(exported: Exported, console: Console) -> dict[str, object]:
    from brdfit.export.record import fit_record

    return {
        "schema": "brdfit.export/1",
        "output": exported.path.name,
        "conversion": exported.conversion.record(),
        "models": {fit.model: fit_record(fit) for fit in exported.fits},
        "warnings": list(console.warnings),
    }


def _tell(exported: Exported, console: Console) -> None:
    if exported.conversion.kind != "none":
        console.say(f"  channels    {exported.conversion}")
    for fit in exported.fits:
        console.say(f"{fit.model}: {fit.form}")
        for name, value in fit.material.parameters().items():
            console.say(f"  {name:<24} {_number(value)}")
        console.say(f"  {'perceptual error':<24} {fit.perceptual_error:.2f} Delta E00")
        console.say(f"  {'of other forms':<24} {_others(fit)}")
        if fit.perceptual_error > _NOTABLE:
            console.warn(
                "FitWarning",
                f"{fit.model} stays {fit.perceptual_error:.1f} Delta E00 from the table: it looks "
                f"like another material. Use a format that holds tables where you can.",
            )
    console.say(f"wrote {exported.path} ({exported.target.title})")


def _others(fit: Analytic) -> str:
    rest = [f"{name} {error:.2f}" for name, error in fit.tried.items() if name != fit.form]
    return ", ".join(rest) or "there are none"


def _number(value: float | list[float]) -> str:
    values = value if isinstance(value, list) else [value]
    return " ".join(f"{one:.4f}" for one in values)
