"""`brdfit fit`: measurements in, the complete BRDF and its doubts out."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.bench.workers import limit_threads
from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.cli.settings import add_settings, given_settings, pick
from brdfit.cli.writing import add_output_format
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Method, Reconstruction
    from brdfit.report.fit_outputs import FitOutputs
    from brdfit.samples import Samples

_NOT_OPTIONS = ("population",)


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit fit` takes; the method named in `rest` decides some of it."""
    parser.add_argument("samples", type=Path, metavar="SAMPLES", help="File of measurements.")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT",
        help="Table to write: .binary (MERL, R G B), .npz or .exr (all channels), .bsdf, .xml. A "
        ".png, a .json and a .csv appear beside it.",
    )
    add_output_format(parser)
    parser.add_argument(
        "--limit-albedo",
        action="store_true",
        help="Lower the table where nobody measured, until no incidence reflects more light than "
        "arrives. Measured cells are not moved; what that leaves above 1 is said.",
    )
    add_method_options(parser, rest)
    add_reading_options(parser)


def add_method_options(parser: Parser, rest: Sequence[str]) -> None:
    """Add --method, --basis, and the options of the method that `rest` names."""
    # Before numpy is imported: the dense result runs on threads of its own, and a threaded
    # linear algebra beneath them, or beneath another program's, waits more than it works.
    limit_threads()
    from brdfit.reconstruct import METHODS

    default = next(iter(METHODS))
    named = _typed_method(rest)
    try:
        key = default if named is None else pick(named, METHODS)
    except UsageError as error:
        parser.typed = ()
        parser.error(str(error))
    basis = _own_population(METHODS[key]) or "none: it leans on no population"
    parser.add_argument(
        "--method",
        default=default,
        metavar="NAME",
        help=f"One of {', '.join(METHODS)} (default: {default}). Each has settings of its own: "
        f"--method NAME --help.",
    )
    parser.add_argument(
        "--basis",
        metavar="NAME|PATH",
        help="Population to lean on: published, embedded, synthetic, nbrdf, a folder of MERL "
        f".binary files, or a zip of networks (default: {basis}).",
    )
    parser.add_argument(
        "--without",
        metavar="MATERIALS",
        help="Leave these materials of the population out, separated by commas.",
    )
    add_settings(parser.add_argument_group(f"settings of {key}"), METHODS[key], _NOT_OPTIONS)


def _typed_method(rest: Sequence[str]) -> str | None:
    for word, after in zip(rest, [*rest[1:], ""], strict=False):
        if word == "--method":
            return after
        if word.startswith("--method="):
            return word.split("=", 1)[1]
    return None


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read, fit, report, write."""
    from brdfit.formats import read_samples
    from brdfit.report.fit_outputs import FitPaths

    # Before any work: is there a place for the result?
    paths = FitPaths.beside(arguments.output, inputs=[arguments.samples], format=arguments.to)
    options = reading_options(arguments)
    samples = read_samples(arguments.samples, **options)
    method = method_from(arguments)
    context = {"command": "fit", "reading": {k: str(v) for k, v in options.items()}}
    fit_and_write(samples, method, paths, console, context, limit_albedo=arguments.limit_albedo)


def method_from(arguments: argparse.Namespace, leave_out: Sequence[str] = ()) -> Method:
    """Return the method with its settings and population, as typed.

    `leave_out` are materials that a population must not hold, besides those typed.
    """
    from brdfit.populations import population
    from brdfit.reconstruct import METHODS

    settings: dict[str, Any] = given_settings(arguments)
    kind = METHODS[pick(arguments.method, METHODS)]
    own = _own_population(kind)
    if own is not None:
        basis = own if arguments.basis is None else arguments.basis
        settings["population"] = basis
        typed = (arguments.without or "").split(",")
        names = [*filter(None, map(str.strip, typed)), *leave_out]
        if names:
            settings["population"] = population(basis).without(names)
    elif arguments.without or arguments.basis is not None:
        raise UsageError(f"--method {arguments.method}: leans on no population; leave out --basis.")
    method: Method = kind(**settings)
    return method


def _own_population(kind: type) -> Any:
    """Return the population that a method leans on unless told otherwise; None if on none."""
    fields = {field.name: field.default for field in dataclasses.fields(kind)}
    return fields.get("population")


def fit_and_write(
    samples: Samples,
    method: Method,
    paths: Any,
    console: Console,
    context: dict[str, Any],
    *,
    limit_albedo: bool = False,
) -> tuple[Reconstruction, FitOutputs]:
    """Report on `samples`, fit them, write the outputs, and say how it all ended."""
    from brdfit.cli.fit_lines import fit_lines
    from brdfit.cli.summary import samples_lines
    from brdfit.reconstruct import fit
    from brdfit.report.fit_outputs import write_fit

    for line in samples_lines(samples):
        console.say(line)
    with console.progress() as progress:
        result = fit(samples, method=method, progress=progress)
    for line in fit_lines(result.record()):
        console.say(line)
    if not result.outcome.ok:
        console.warn("FitWarning", f"{result.outcome.value}: {result.outcome.advice}")
    with console.progress() as progress:
        context = {**context, "warnings": list(console.warnings)}
        outputs = write_fit(
            result, paths, context=context, limit_albedo=limit_albedo, progress=progress
        )
    _say_albedo(outputs, console)
    if outputs.conversion.kind != "none":
        console.say(f"  channels    {outputs.conversion}")
    console.say(f"wrote {paths.table}")
    for path in paths.all()[1:]:
        console.say(f"      {path}")
    return result, outputs


def _say_albedo(outputs: FitOutputs, console: Console) -> None:
    console.say(f"  albedo      {outputs.albedo}")
    if outputs.limited is None:
        if outputs.albedo.above_one:
            console.say("              --limit-albedo lowers it where nobody measured")
    elif outputs.limited.reached:
        console.say(f"              {outputs.limited.sentence}")
    else:
        console.warn("FitWarning", outputs.limited.sentence)
