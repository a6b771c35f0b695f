"""`brdfit report`: one HTML file about a fit."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.cli.commands.fit import add_method_options, method_from
from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.cli.settings import given_settings
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.report.fitted import Fitted
    from brdfit.samples import Samples


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit report` takes."""
    parser.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="What brdfit fit left: the table, its .json or its .csv (each leads to the others); "
        "any other table; or measurements, which are fitted first.",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="HTML",
        help="Report to write: one .html that opens from disk and needs no network.",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        metavar="FILE",
        help="Table or measurements to compare with.",
    )
    parser.add_argument(
        "--as",
        dest="kind",
        choices=["samples", "table"],
        default="table",
        help="What FILE is, if it can be read as both (default: table).",
    )
    add_method_options(parser, rest)
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Gather or fit, compare, write the page."""
    from brdfit.report.page.write import checked_target, write_report
    from brdfit.report.reading import read_any

    # Before any work: is there a place for the result?
    target = checked_target(arguments.output)
    for given in filter(None, (arguments.file, arguments.reference)):
        if given.resolve() == target.resolve():
            raise UsageError(f"{target}: is an input; the report must be another file.")
    fitted = _fitted(arguments, console)
    for note in fitted.notes:
        console.say(f"note: {note}")
    reference = None
    if arguments.reference is not None:
        reference = read_any(arguments.reference, {}, "table")
    with console.progress() as progress:
        write_report(fitted, target, reference=reference, progress=progress)
    console.say(f"wrote {target} ({target.stat().st_size / 1e6:.1f} MB)")


def _fitted(arguments: argparse.Namespace, console: Console) -> Fitted:
    from brdfit.report.fit_files import FitFiles, read_fit
    from brdfit.report.reading import read_any
    from brdfit.samples import Samples

    path: Path = arguments.file
    if path.suffix.lower() in (".json", ".csv") and path.is_file():
        files = FitFiles.around(path)
        if files is not None:
            _refuse_method(arguments)
            return read_fit(files)
        if path.suffix.lower() == ".json":
            raise UsageError(f"{path.name}: is JSON but not the record of a fit.")
    content = read_any(path, reading_options(arguments), arguments.kind)
    if isinstance(content, Samples):
        return _fit_first(content, arguments, console)
    _refuse_method(arguments)
    files = FitFiles.around(path)
    assert files is not None
    return read_fit(files, content)


def _refuse_method(arguments: argparse.Namespace) -> None:
    if given_settings(arguments) or arguments.without or arguments.basis is not None:
        raise UsageError(
            f"{arguments.file}: is fitted already; the settings of a method are for measurements. "
            f"Leave them out, or name the file of the measurements."
        )


def _fit_first(samples: Samples, arguments: argparse.Namespace, console: Console) -> Fitted:
    from brdfit.cli.fit_lines import fit_lines
    from brdfit.cli.summary import samples_lines
    from brdfit.reconstruct import fit
    from brdfit.report.fitted import Fitted, UsedFile

    for line in samples_lines(samples):
        console.say(line)
    with console.progress() as progress:
        result = fit(samples, method=method_from(arguments), progress=progress)
        fitted = Fitted.of(result, progress)
    for line in fit_lines(result.record()):
        console.say(line)
    reading = {name: str(value) for name, value in reading_options(arguments).items()}
    context = {"command": "report", "reading": reading, "warnings": list(console.warnings)}
    return replace(
        fitted,
        record={**fitted.record, **context},
        files=(UsedFile.of("measurements", arguments.file),),
    )
