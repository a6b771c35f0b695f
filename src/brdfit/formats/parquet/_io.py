"""Read and write samples as Parquet."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import CorruptFile, UsageError
from brdfit.files import atomic_path, sha256_of_file
from brdfit.formats.declaration import Column, coerce, position_of, samples_from
from brdfit.formats.declared import declare
from brdfit.formats.own import OwnHeader, own_columns, own_source, samples_from_own
from brdfit.formats.sidecar import read_sidecar
from brdfit.formats.text import name_lines, parse_number
from brdfit.samples import Samples, Source

__all__ = ["read_samples", "write_samples"]

_NAME = "parquet"
_KEY = b"brdfit samples"


def read_samples(path: Path, **options: Any) -> Samples:
    """Read samples; options are those of `Declaration`, a TOML sidecar may hold them too.

    `rows` are 1-based records. A record with text where a number was declared is flagged
    `UNREADABLE`.
    """
    table = _open(path)
    given, sidecar = read_sidecar(path)
    declared = {**given, **{key: value for key, value in options.items() if value is not None}}
    source = Source(name=path.name, format=_NAME, sha256=sha256_of_file(path))
    own = (table.schema.metadata or {}).get(_KEY)
    if own is not None and not declared:
        return _read_own(table, OwnHeader.from_json(own.decode(), path.name), source)
    where = sidecar if sidecar and not options else path.name
    declared = {key: coerce(key, value, where) for key, value in declared.items()}
    columns = _Columns(table, path.name)
    declaration, notes = declare(path.name, table.column_names, declared, columns.take)
    if sidecar:
        notes.insert(0, f"columns declared in {sidecar}")
    used: list[Column] = [
        *(c for c in declaration.directions if not (isinstance(c, str) and c.startswith("="))),
        *declaration.values,
        *declaration.sigma,
        *([] if declaration.flags is None else [declaration.flags]),
    ]
    readable = np.logical_and.reduce([columns.readable(column) for column in used])
    records = np.arange(1, table.num_rows + 1)
    if not readable.all():
        notes.append(name_lines("records that could not be read", records[~readable]))
    names: dict[Column, str] = {c: table.column_names[columns.position(c)] for c in used}
    noted = Source(name=source.name, format=_NAME, sha256=source.sha256, notes=tuple(notes))
    return samples_from(declaration, columns.take, names, readable, records, noted)


def write_samples(samples: Samples, path: Path) -> None:
    """Write `samples` with flags, rows, wavelengths and source; reads back exactly."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    header = OwnHeader.of(samples)
    arrays = [pa.array(column) for column in own_columns(samples)]
    names = _unlike(header.column_names())
    table = pa.Table.from_arrays(arrays, names=names)
    table = table.replace_schema_metadata({_KEY: header.to_json().encode()})
    with atomic_path(path) as aside:
        pq.write_table(table, aside)


class _Columns:
    """Columns of an Arrow table as floats, each with a mask of the records it could read."""

    def __init__(self, table: Any, where: str) -> None:
        self._table = table
        self._where = where
        self._known: dict[int, tuple[FloatArray, BoolArray]] = {}

    def position(self, column: Column) -> int:
        return position_of(column, self._table.column_names, self._where)

    def take(self, column: Column) -> FloatArray:
        return self._column(column)[0]

    def readable(self, column: Column) -> BoolArray:
        return self._column(column)[1]

    def _column(self, column: Column) -> tuple[FloatArray, BoolArray]:
        position = self.position(column)
        if position not in self._known:
            name = self._table.column_names[position]
            self._known[position] = _as_floats(self._table.column(position), name, self._where)
        return self._known[position]


def _as_floats(column: Any, name: str, where: str) -> tuple[FloatArray, BoolArray]:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
        numbers = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
        return np.asarray(numbers, dtype=np.float64), np.ones(len(numbers), dtype=bool)
    if pa.types.is_decimal(kind):
        numbers = [np.nan if item is None else float(item) for item in column.to_pylist()]
        return np.array(numbers, dtype=np.float64), np.ones(len(numbers), dtype=bool)
    if not (pa.types.is_string(kind) or pa.types.is_large_string(kind)):
        raise UsageError(
            f"{where}: column {name!r} holds {kind} but numbers were expected. "
            f"Declare another column, or write it as float64."
        )
    parsed = [parse_number("" if item is None else item) for item in column.to_pylist()]
    cells = np.array([np.nan if item is None else item for item in parsed], dtype=np.float64)
    return cells, np.array([item is not None for item in parsed], dtype=bool)


def _open(path: Path) -> Any:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(path).read()
    except (pa.ArrowException, OSError) as error:
        raise CorruptFile(
            f"{path.name}: begins like Parquet but cannot be read ({error}). It looks "
            f"truncated or damaged; copy or export it again."
        ) from error
    if table.num_rows == 0:
        raise CorruptFile(f"{path.name}: holds no record, but measurements were expected.")
    return table


def _read_own(table: Any, header: OwnHeader, source: Source) -> Samples:
    found, wanted = table.column_names, _unlike(header.column_names())
    if found != wanted:
        raise CorruptFile(
            f"{source.name}: the columns {', '.join(found)} are not those that its header "
            f"describes ({', '.join(wanted)}). Declare the columns by options instead."
        )
    cells = np.stack([_as_floats(column, "", source.name)[0] for column in table.columns], axis=1)
    readable = np.ones(len(cells), dtype=bool)
    records = np.arange(1, len(cells) + 1)
    return samples_from_own(header, cells, readable, records, own_source(header.source, source))


def _unlike(names: Sequence[str]) -> list[str]:
    """Names made different from one another: a channel may be called like a column of ours."""
    result: list[str] = []
    for name in names:
        unlike, copy = name, 2
        while unlike in result:
            unlike, copy = f"{name}#{copy}", copy + 1
        result.append(unlike)
    return result
