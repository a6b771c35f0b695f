"""Write samples as CSV that reads back exactly."""

from __future__ import annotations

import csv
import io
from pathlib import Path

from brdfit.files import atomic_path
from brdfit.formats.own import OwnHeader, own_columns
from brdfit.samples import Samples

__all__ = ["OWN_PREFIX", "write_samples"]

OWN_PREFIX = "# brdfit samples "
"""How our own files begin; the header in JSON follows in the same line."""


def write_samples(samples: Samples, path: Path) -> None:
    """Write `samples` with flags, rows, wavelengths and source.

    Numbers have the digits that bring the same float64 back.
    """
    import pyarrow as pa
    import pyarrow.csv as pa_csv

    header = OwnHeader.of(samples)
    names = io.StringIO()
    csv.writer(names, lineterminator="\n").writerow(header.column_names())
    arrays = [pa.array(column) for column in own_columns(samples)]
    columns = [f"column{place}" for place in range(len(arrays))]
    table = pa.Table.from_arrays(arrays, names=columns)
    with atomic_path(path) as aside, open(aside, "wb") as stream:
        stream.write(f"{OWN_PREFIX}{header.to_json()}\n{names.getvalue()}".encode())
        pa_csv.write_csv(table, stream, pa_csv.WriteOptions(include_header=False))
