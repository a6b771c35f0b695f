"""`brdfit demo`: the main job on measurements that brdfit makes for the purpose."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.console import Console
from brdfit.cli.parser import Parser

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Reconstruction
    from brdfit.report.demo_input import DemoInput
    from brdfit.table import Table

_INPUT = "demo-measurements.csv"
_OUTPUT = "demo.binary"


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit demo` takes."""
    from brdfit.cli.commands.fit import add_method_options

    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("demo-output"),
        metavar="DIR",
        help="Folder for the input and the outputs; made if missing (default: demo-output).",
    )
    add_method_options(parser, rest)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Make the input, fit it, and hold the result against what it was made from."""
    from brdfit.cli.commands.fit import fit_and_write, method_from
    from brdfit.formats import read_samples
    from brdfit.report.demo_input import DEMO_MATERIAL, demo_input, write_demo_input
    from brdfit.report.fit_outputs import FitPaths

    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / _INPUT
    demo = demo_input()
    write_demo_input(demo, source)
    console.say(f"made {source}: GENERATED from a published fit ({demo.member}),")
    console.say(
        f"  with {demo.noise:.0%} noise, gaps and {int(demo.outliers.sum())} outliers; not a "
        f"measurement. {DEMO_MATERIAL} is left out of the population that the fit leans on."
    )
    console.say()
    paths = FitPaths.beside(folder / _OUTPUT, inputs=[source])
    console.say(f"$ brdfit fit {source} -o {paths.table} --without {DEMO_MATERIAL}")
    method = method_from(arguments, leave_out=[DEMO_MATERIAL])
    samples = read_samples(source)
    context = {"command": "demo", "generated_from": demo.member, "seed": demo.seed}
    result, outputs = fit_and_write(samples, method, paths, console, context)
    console.say()
    for line in _against_the_truth(demo, result, outputs.table):
        console.say(line)


def _against_the_truth(demo: DemoInput, result: Reconstruction, written: Table) -> list[str]:
    from brdfit.report.compare import compare

    comparison = compare(demo, written, illuminations=("studio",))
    found = result.outliers
    hits = int((found & demo.outliers).sum())
    return [
        "against what the input was made from, which no real measurement comes with:",
        f"  outliers    {hits} of the {int(demo.outliers.sum())} found (a factor near 1 does no "
        f"harm), {int((found & ~demo.outliers).sum())} good samples suspected",
        f"  perceptual  {comparison.perceptual_error:.2f} (mean CIEDE2000 of a rendered sphere; "
        f"1 is just noticeable)",
        f"  values      mean |delta ln f| {comparison.values['mean_abs_log'].value:.3f} over the "
        f"whole domain",
    ]
