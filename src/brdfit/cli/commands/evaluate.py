"""`brdfit evaluate`: a table at directions of your own."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.samples import Samples


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit evaluate` takes."""
    parser.add_argument("file", type=Path, metavar="FILE", help="Table to evaluate.")
    parser.add_argument(
        "--at",
        type=Path,
        required=True,
        metavar="DIRECTIONS",
        help="CSV or Parquet of directions, or any file of measurements: its values are not used.",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT",
        help="Samples to write, .csv or .parquet: the directions, and f_r in 1/sr.",
    )
    add_reading_options(parser, "reading the directions")


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the table and the directions, write the values."""
    import numpy as np

    from brdfit.formats import write_samples
    from brdfit.report.reading import read_table_of
    from brdfit.samples import Samples, Source

    output = arguments.output
    for taken in (arguments.file, arguments.at):
        if output.resolve() == taken.resolve():
            raise UsageError(f"{output}: is an input; the output must be another file.")
    at = _read_directions(arguments.at, reading_options(arguments))
    table = read_table_of(arguments.file)
    defined = (at.wi[:, 2] > 0.0) & (at.wo[:, 2] > 0.0)
    value = np.full((len(at), table.n_channels), np.nan)
    value[defined] = table.evaluate(at.wi[defined], at.wo[defined])
    result = Samples(
        wi=at.wi,
        wo=at.wo,
        value=value,
        wavelengths=table.wavelengths,
        channels=table.channels,
        rows=at.rows,
        source=Source(name=table.source.name, format=table.source.format),
    )
    write_samples(result, output)
    undefined = int((~defined).sum())
    if undefined:
        console.warn(
            "DataQualityWarning",
            f"{undefined} of {len(at)} directions are at or below the horizon or not finite, where "
            f"no BRDF is defined: their values are left empty.",
        )
    console.say(f"wrote {output} ({len(at)} directions, {', '.join(table.channels)})")


def _read_directions(path: Path, options: dict[str, Any]) -> Samples:
    """Return samples whose directions count and whose values do not.

    A file of measurements is read as one; a file of nothing but directions has no column
    of values, so its first column is declared to be one.
    """
    import warnings

    from brdfit.errors import DataQualityWarning, FormatError
    from brdfit.formats import read_samples

    with warnings.catch_warnings():
        # These are about values; what is wrong with directions is counted by the caller.
        warnings.simplefilter("ignore", DataQualityWarning)
        try:
            return read_samples(path, **options)
        except (UsageError, FormatError):
            if "values" in options:
                raise
        kind = "parquet" if path.suffix.lower() in (".parquet", ".pq") else "delimited"
        return read_samples(path, **{"format": kind, **options, "values": (1,)})
