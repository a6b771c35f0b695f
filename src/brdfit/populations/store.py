"""Log columns of a population on disk: built once, checked when opened, read in blocks.

One folder for each (source, grid): a raw float32 file for each channel, row-major
(cells, members of the source), and a manifest that says what they must be. The folder
appears under its name only when it is complete.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray, frozen
from brdfit.errors import PopulationError
from brdfit.files import sha256_of_bytes
from brdfit.grid import Grid
from brdfit.populations.cache import cache_folder
from brdfit.populations.contract import VALUE_FLOOR, MemberSource

__all__ = [
    "CHUNK",
    "FLOAT",
    "MANIFEST",
    "Store",
    "checksums",
    "columns_folder",
    "intact",
    "stored_cells",
]

CHUNK = 4096
"""Rows that are written, and have their checksum, together."""

MANIFEST = "manifest.json"
FLOAT = np.dtype("<f4")

# Raise it when the layout of the files, or what is stored in them, changes.
_VERSION = 1
# Bytes: reading a gap of that size costs less than a read of its own; no piece is longer.
_GAP, _PIECE = 1 << 15, 1 << 22


def columns_folder() -> Path:
    """Return the folder of all stores."""
    return cache_folder("columns")


@lru_cache(maxsize=8)
def stored_cells(grid: Grid, bilateral: bool) -> tuple[IntArray, IntArray]:
    """Return (cells, expand): which flat cells are stored, and where to find the others.

    `expand` (grid.cells.size,) is the position in `cells` of each of `grid.cells`. Where
    f(phi_d) = f(pi - phi_d), half the azimuths say it all: node k equals node n - k.
    """
    i, j, k = np.unravel_index(grid.cells, grid.shape)
    if bilateral:
        k = np.minimum(k, (grid.n_phi_d - k) % grid.n_phi_d)
    representative = np.ravel_multi_index((i, j, k), grid.shape)
    is_stored = np.zeros(grid.size, dtype=bool)
    is_stored[representative] = True
    position = np.cumsum(is_stored) - 1
    return frozen(np.flatnonzero(is_stored)), frozen(position[representative])


@dataclass(frozen=True, eq=False)
class Store:
    """Where the columns of a source on a grid are, and what they must look like."""

    source: MemberSource
    grid: Grid

    @cached_property
    def folder(self) -> Path:
        """The folder, whether it exists or not; it is named by the content it must have."""
        text = json.dumps([self.source.fingerprint, self.grid.shape, VALUE_FLOOR, _VERSION])
        return columns_folder() / sha256_of_bytes(text.encode())[:24]

    @cached_property
    def members(self) -> int:
        """Number of columns of a file."""
        return len(self.source.members)

    @cached_property
    def facts(self) -> dict[str, Any]:
        """What the manifest must say, as JSON-able values."""
        cells, _ = stored_cells(self.grid, self.source.bilateral)
        return {
            "version": _VERSION,
            "fingerprint": self.source.fingerprint,
            "grid": list(self.grid.shape),
            "floor": VALUE_FLOOR,
            "cells": int(cells.size),
            "members": self.members,
            "channels": list(self.source.channels),
            "chunk": CHUNK,
        }

    def path(self, channel: int) -> Path:
        """Return the file of a channel."""
        return self.folder / f"{self.source.channels[channel]}.f32"

    def read(self, channel: int, start: int, stop: int) -> FloatArray:
        """Return rows [start, stop) of a channel, (stop - start, members), float32."""
        count = (stop - start) * self.members
        offset = start * self.members * FLOAT.itemsize
        with self._open(channel) as stream:
            return self._values(stream, offset, count).reshape(-1, self.members)

    def gather(self, channel: int, index: IntArray) -> Iterator[tuple[IntArray, FloatArray]]:
        """Yield (positions in `index`, rows) until every row of `index` was read.

        Rows are read in the order of the file, neighbours in one piece.
        """
        order = np.argsort(index, kind="stable")
        ascending = index[order]
        width = self.members * FLOAT.itemsize
        with self._open(channel) as stream:
            for first, last in _runs(ascending, width):
                low, high = int(ascending[first]), int(ascending[last - 1]) + 1
                rows = self._values(stream, low * width, (high - low) * self.members)
                yield order[first:last], rows.reshape(-1, self.members)[ascending[first:last] - low]

    def _open(self, channel: int) -> BufferedReader:
        try:
            return open(self.path(channel), "rb")
        except OSError as error:
            raise PopulationError(
                f"{self.path(channel)}: the cached columns of {self.source.name!r} were removed "
                f"while in use. Run again: they are built anew."
            ) from error

    def _values(self, stream: BufferedReader, offset: int, count: int) -> FloatArray:
        # Plain reads: the pages of a memory map would count as memory of this process.
        values = np.empty(count, dtype=FLOAT)
        stream.seek(offset)
        if stream.readinto(values.data) != values.nbytes:
            raise PopulationError(
                f"{stream.name}: the cached columns of {self.source.name!r} are shorter than "
                f"their manifest says. Remove them with: brdfit basis clear"
            )
        return values


def _runs(ascending: IntArray, width: int) -> Iterator[tuple[int, int]]:
    """Yield [first, last) of the rows, `width` bytes each, that are read in one piece."""
    gap, piece = max(1, _GAP // width), max(1, _PIECE // width)
    first = 0
    for last in [*(np.flatnonzero(np.diff(ascending) > gap) + 1), ascending.size]:
        while first < last:
            limit = np.searchsorted(ascending, ascending[first] + piece)
            end = min(int(limit), int(last))
            yield first, end
            first = end


def intact(store: Store, thorough: bool = False) -> bool:
    """Return whether the files are what their manifest says.

    Sizes and times of change are compared; the content is read and its checksums compared
    where a time differs, or if `thorough`.
    """
    try:
        manifest = json.loads((store.folder / MANIFEST).read_text())
        if manifest["columns"] != store.facts:
            return False
        entries = manifest["files"]
        for channel in range(len(store.source.channels)):
            path, entry = store.path(channel), entries[channel]
            status = path.stat()
            if status.st_size != entry["size"]:
                return False
            touched = status.st_mtime_ns != entry["mtime_ns"]
            if (thorough or touched) and checksums(path, store) != entry["crc32"]:
                return False
            if touched:
                # Copied, or restored from a backup, and still the same: not checked again.
                os.utime(path, ns=(entry["mtime_ns"], entry["mtime_ns"]))
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        return False
    return True


def checksums(path: Path, store: Store) -> list[int]:
    """Return the CRC-32 of each chunk of a file."""
    size = CHUNK * store.members * FLOAT.itemsize
    with open(path, "rb") as stream:
        return [zlib.crc32(block) for block in iter(lambda: stream.read(size), b"")]
