"""Long tables column by column, some rows at a time: Parquet files and Zarr groups."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from brdfit.errors import CorruptFile, MissingExtra, UsageError

__all__ = ["LongTable", "ParquetTable", "ZarrTable", "require_zarr"]

_CHUNK = 1 << 20


class LongTable(Protocol):
    """A table of named columns, too long to be held."""

    path: str
    names: tuple[str, ...]
    rows: int

    def read(self, names: Sequence[str], start: int, stop: int) -> dict[str, np.ndarray]:
        """Return the columns `names` of rows `start` to `stop`."""

    def scan(self, name: str) -> Iterator[np.ndarray]:
        """Yield one column from the beginning to the end."""


class ParquetTable:
    """A Parquet file; whole row groups are decoded, the last one is kept."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._open()

    def _open(self) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        try:
            self._file = pq.ParquetFile(self.path)
        except (pa.ArrowException, OSError) as error:
            raise CorruptFile(
                f"{Path(self.path).name}: cannot be read as Parquet ({error}). It looks "
                f"truncated or damaged; copy or export it again."
            ) from error
        meta = self._file.metadata
        counts = [meta.row_group(i).num_rows for i in range(meta.num_row_groups)]
        self._starts = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
        self.names = tuple(self._file.schema_arrow.names)
        self.rows = int(self._starts[-1])
        self._held: tuple[int, tuple[str, ...], dict[str, np.ndarray]] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["path"])  # type: ignore[misc]

    def read(self, names: Sequence[str], start: int, stop: int) -> dict[str, np.ndarray]:
        """Return the columns `names` of rows `start` to `stop`."""
        first = int(np.searchsorted(self._starts, start, side="right")) - 1
        parts: list[dict[str, np.ndarray]] = []
        for group in range(first, len(self._starts) - 1):
            low = int(self._starts[group])
            if low >= stop:
                break
            columns = self._group(group, tuple(names))
            rows = slice(max(start - low, 0), stop - low)
            parts.append({name: column[rows] for name, column in columns.items()})
        return {name: np.concatenate([part[name] for part in parts]) for name in names}

    def scan(self, name: str) -> Iterator[np.ndarray]:
        """Yield one column from the beginning to the end."""
        for batch in self._file.iter_batches(_CHUNK, columns=[name]):
            yield _as_numpy(batch.column(0), name, self.path)

    def _group(self, group: int, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        if self._held is None or self._held[:2] != (group, names):
            self._held = None  # let go of the last one before the next is decoded
            table = self._file.read_row_group(group, columns=list(names))
            self._held = (
                group,
                names,
                {name: _as_numpy(table.column(name), name, self.path) for name in names},
            )
        return self._held[2]


def _as_numpy(column: Any, name: str, path: str) -> np.ndarray:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_dictionary(kind):
        column, kind = column.cast(kind.value_type), kind.value_type
    if pa.types.is_integer(kind) and column.null_count == 0:
        return np.asarray(column.to_numpy(zero_copy_only=False))
    if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind):
        return np.asarray(column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False))
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return np.array(column.to_pylist(), dtype=object)
    raise UsageError(
        f"{Path(path).name}: column {name!r} holds {kind} but numbers or words were expected. "
        f"Declare another column, or write it as float64."
    )


class ZarrTable:
    """A Zarr group of arrays of one length, each a column."""

    def __init__(self, path: str) -> None:
        self.path = path
        group = require_zarr().open_group(path, mode="r")
        self._arrays = {n: a for n, a in group.arrays() if a.ndim == 1}
        lengths = {a.shape[0] for a in self._arrays.values()}
        if len(lengths) != 1:
            raise UsageError(
                f"{Path(path).name}: found arrays of {len(lengths)} lengths but the columns of "
                f"a long table (item, directions, values) are 1-D arrays of one length."
            )
        self.names = tuple(sorted(self._arrays))
        self.rows = int(lengths.pop())

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["path"])  # type: ignore[misc]

    def read(self, names: Sequence[str], start: int, stop: int) -> dict[str, np.ndarray]:
        """Return the columns `names` of rows `start` to `stop`."""
        return {name: np.asarray(self._arrays[name][start:stop]) for name in names}

    def scan(self, name: str) -> Iterator[np.ndarray]:
        """Yield one column from the beginning to the end."""
        for start in range(0, self.rows, _CHUNK):
            yield np.asarray(self._arrays[name][start : start + _CHUNK])


def require_zarr() -> Any:
    """Return the module zarr, or say how to have it."""
    try:
        import zarr
    except ImportError as error:
        raise MissingExtra("zarr", "batch", "a store of many items") from error
    return zarr
