"""One long table, Parquet or Zarr: the rows of an item follow one another."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.batch.columns import LongTable
from brdfit.batch.source import Part
from brdfit.errors import SampleError, UsageError
from brdfit.files import sha256_of_file
from brdfit.formats.declaration import Column, Declaration, coerce, position_of, samples_from
from brdfit.formats.declared import declare
from brdfit.formats.sidecar import read_sidecar
from brdfit.reconstruct.compact import Block
from brdfit.samples import Samples, Source

__all__ = ["TableInput"]

# Row numbers are kept of every so many-th item: what is between is found when it is read.
_STRIDE = 64
_SOME = 100_000
_ITEM_NAMES = ("item", "item_id", "material", "point", "sample_id")


@dataclass(frozen=True, eq=False)
class TableInput:
    """Items of a long table: what its columns mean, and where every 64th item begins."""

    table: LongTable
    declaration: Declaration
    columns: tuple[str, ...]
    """Names that `declaration` counts."""
    item: str
    position: tuple[str, ...]
    starts: IntArray
    """First row of items 0, 64, 128, ..., and the number of rows."""
    count: int
    longest_name: int
    notes: tuple[str, ...]
    channels: tuple[str, ...] = ()
    wavelengths: tuple[float, ...] = ()
    """Both as the first rows have them; empty until they are read."""

    @classmethod
    def of(
        cls,
        table: LongTable,
        options: Mapping[str, Any],
        item: str | None = None,
        position: Sequence[str] = (),
    ) -> TableInput:
        """Return the items of a table.

        `options` are those of `Declaration`; a TOML sidecar may hold them too. `item` and
        `position` name columns; left out, `item` and, if there are, `x` and `y` are taken.
        Raises `UsageError` where a column is missing or not clear, `SampleError` where the
        rows of an item are scattered.
        """
        where = Path(table.path).name
        item = _item_column(table, item)
        position = tuple(position) or _position_columns(table)
        columns = tuple(n for n in table.names if n != item and n not in position)
        given, sidecar = read_sidecar(Path(table.path))
        raw = {**given, **options}
        raw = {k: coerce(k, v, sidecar or where) for k, v in raw.items() if v is not None}
        some: dict[str, np.ndarray] = {}

        def take(column: Column) -> FloatArray:
            name = columns[position_of(column, columns, where)]
            if name not in some:
                some[name] = table.read([name], 0, min(_SOME, table.rows))[name]
            return _numbers(some[name], name, where)

        declaration, notes = declare(where, columns, raw, take)
        starts, count, longest = _index(table, item)
        found = cls(
            table=table,
            declaration=declaration,
            columns=columns,
            item=item,
            position=position,
            starts=starts,
            count=count,
            longest_name=longest,
            notes=tuple(notes),
        )
        return found._with_channels()

    def _with_channels(self) -> TableInput:
        first = self._samples(0, min(8, self.table.rows))[0]
        bands = () if first.wavelengths is None else tuple(first.wavelengths.tolist())
        return replace(self, channels=first.channels, wavelengths=bands)

    @property
    def name(self) -> str:
        """Name of the file."""
        return Path(self.table.path).name

    @property
    def samples_per_item(self) -> float:
        """Rows of an item, on average."""
        return self.table.rows / max(self.count, 1)

    @property
    def positioned(self) -> bool:
        """Whether items have pixel positions."""
        return bool(self.position)

    def fingerprint(self) -> str:
        """SHA-256 over the file (or every file of the group) and what its columns mean."""
        digest = hashlib.sha256(repr((self.declaration, self.item, self.position)).encode())
        path = Path(self.table.path)
        for file in sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]:
            digest.update(f"{file.relative_to(path.parent)}\0{sha256_of_file(file)}\0".encode())
        return digest.hexdigest()

    def part(self, start: int, stop: int) -> Part:
        """Read items `start` to `stop`."""
        low = start // _STRIDE
        high = min(-(-stop // _STRIDE), len(self.starts) - 1)
        first_row, last_row = int(self.starts[low]), int(self.starts[high])
        samples, ids, position = self._samples(first_row, last_row)
        begins = np.flatnonzero(_changes(ids))
        chosen = begins[start - low * _STRIDE : stop - low * _STRIDE]
        following = begins[stop - low * _STRIDE :]
        end = int(following[0]) if following.size else len(ids)
        rows = slice(int(chosen[0]), end)
        if rows != slice(0, len(ids)):  # parts that begin and end with every 64th item are whole
            samples = samples.subset(np.arange(len(ids))[rows])
        block = Block(samples, _offsets(chosen, end))
        return Part(
            names=[str(name) for name in ids[chosen]],
            block=block,
            where=list(range(len(chosen))),
            position=None if position is None else position[chosen],
        )

    def _samples(self, start: int, stop: int) -> tuple[Samples, np.ndarray, FloatArray | None]:
        declaration, where = self.declaration, self.name
        used: list[Column] = [*declaration.directions, *declaration.values, *declaration.sigma]
        used += [] if declaration.flags is None else [declaration.flags]
        held = [c for c in used if not (isinstance(c, str) and c.startswith("="))]
        names: dict[Column, str] = {
            c: self.columns[position_of(c, self.columns, where)] for c in held
        }
        wanted = list(dict.fromkeys([*names.values(), self.item, *self.position]))
        read = self.table.read(wanted, start, stop)
        samples = samples_from(
            declaration,
            lambda column: _numbers(read[names[column]], names[column], where),
            names,
            np.ones(stop - start, dtype=bool),
            np.arange(start + 1, stop + 1),
            Source(name=where, format="long table", notes=self.notes),
        )
        position = None
        if self.position:
            position = np.stack([_numbers(read[n], n, where) for n in self.position], axis=1)
        return samples, read[self.item], position


def _offsets(begins: IntArray, end: int) -> IntArray:
    return np.concatenate([begins - begins[0], [end - begins[0]]])


def _changes(ids: np.ndarray) -> np.ndarray:
    """(n,) True where a row belongs to another item than the row before it."""
    return np.concatenate([[True], ids[1:] != ids[:-1]])


def _numbers(column: np.ndarray, name: str, where: str) -> FloatArray:
    try:
        return np.asarray(column, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"{where}: column {name!r} holds words but numbers were expected."
        ) from error


def _item_column(table: LongTable, item: str | None) -> str:
    where = Path(table.path).name
    if item is not None:
        return table.names[position_of(item, table.names, where)]
    for name in table.names:
        if name.strip().lower() in _ITEM_NAMES:
            return name
    raise UsageError(
        f"{where}: no column says which item a row belongs to ({', '.join(_ITEM_NAMES)}). Name "
        f"it: --item COLUMN. Columns: {', '.join(table.names)}."
    )


def _position_columns(table: LongTable) -> tuple[str, ...]:
    return ("x", "y") if {"x", "y"} <= set(table.names) else ()


def _index(table: LongTable, item: str) -> tuple[IntArray, int, int]:
    """Return (rows where every 64th item begins and the number of rows, items, longest name)."""
    starts: list[int] = []
    hashes: list[np.ndarray] = []
    count, row, longest = 0, 0, 1
    last: Any = None
    for ids in table.scan(item):
        changes = _changes(ids)
        changes[0] = row == 0 or ids[0] != last
        places = np.flatnonzero(changes)
        fresh = ids[places]
        starts += [int(row + p) for p in places[(-count) % _STRIDE :: _STRIDE]]
        count += len(places)
        longest = max([longest, *_lengths(fresh)])
        hashes.append(_hashes(fresh))
        row, last = row + len(ids), ids[-1]
    _refuse_scattered(table, item, hashes)
    return np.array([*starts, row], dtype=np.int64), count, longest


def _lengths(ids: np.ndarray) -> list[int]:
    if ids.dtype == object:
        return [len(str(name).encode()) for name in ids]
    return [len(str(ids.min())), len(str(ids.max()))] if len(ids) else []


def _hashes(ids: np.ndarray) -> np.ndarray:
    if ids.dtype != object:
        return ids
    digest = (hashlib.blake2b(str(name).encode(), digest_size=8).digest() for name in ids)
    return np.frombuffer(b"".join(digest), dtype=np.uint64)


def _refuse_scattered(table: LongTable, item: str, hashes: list[np.ndarray]) -> None:
    every = np.sort(np.concatenate(hashes))
    again = every[1:][every[1:] == every[:-1]]
    if again.size:
        example = "" if every.dtype == np.uint64 else f" (item {again[0]}, for one)"
        raise SampleError(
            f"{Path(table.path).name}: the rows of {len(np.unique(again))} items are scattered"
            f"{example}, but the rows of an item must follow one another. Sort the table by "
            f"{item!r} first."
        )


def _key(options: Mapping[str, Any]) -> str:
    return json.dumps(sorted(options.items()), default=str)
