"""How the columns of a population get onto the disk, by all processors, whole or not at all."""

from __future__ import annotations

import json
import os
import shutil
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import PopulationError
from brdfit.grid import Grid
from brdfit.populations.cache import CACHE_VARIABLE, locked
from brdfit.populations.contract import VALUE_FLOOR, MemberSource, TabulatedSource
from brdfit.populations.store import CHUNK, FLOAT, MANIFEST, Store, intact, stored_cells
from brdfit.progress import Progress, silent

__all__ = ["open_store"]

_WORKERS = 8


def open_store(source: MemberSource, grid: Grid, progress: Progress = silent) -> Store:
    """Return the store of `source` on `grid`, built first where it is missing or damaged.

    Two processes that ask at once build once: the second waits, then reads.
    """
    store = Store(source, grid)
    if not intact(store):
        with locked(store.folder):
            if not intact(store):
                _build(store, progress)
    return store


def _build(store: Store, progress: Progress) -> None:
    aside = store.folder.with_name(f".{store.folder.name}.part")
    # Left by a process that was killed; the lock says that nobody else is at it.
    shutil.rmtree(aside, ignore_errors=True)
    _require_space(store)
    try:
        aside.mkdir()
        builder = _Builder(store, aside, progress)
        builder.fill()
        builder.write_manifest()
        shutil.rmtree(store.folder, ignore_errors=True)
        os.replace(aside, store.folder)
    except OSError as error:
        raise PopulationError(
            f"{store.folder.parent}: the columns of {store.source.name!r} could not be written "
            f"({error.strerror or error}). Make room, or name another folder in the environment "
            f"variable {CACHE_VARIABLE}."
        ) from error
    finally:
        # Renamed by now, if all went well; otherwise nothing half-written stays.
        shutil.rmtree(aside, ignore_errors=True)


def _require_space(store: Store) -> None:
    cells, members = store.facts["cells"], store.members
    needed = cells * members * FLOAT.itemsize * len(store.source.channels)
    if isinstance(store.source, TabulatedSource):
        needed *= 2
    free = shutil.disk_usage(store.folder.parent).free
    if free < needed:
        raise PopulationError(
            f"{store.folder.parent}: {free / 1e9:.1f} GB are free but the columns of "
            f"{store.source.name!r} need {needed / 1e9:.1f} GB. Make room, or name another "
            f"folder in the environment variable {CACHE_VARIABLE}."
        )


class _Builder:
    """Fills the files of one store in a folder aside."""

    def __init__(self, store: Store, folder: Path, progress: Progress) -> None:
        self._store = store
        self._source = store.source
        self._progress = progress
        self._cells, _ = stored_cells(store.grid, store.source.bilateral)
        self._starts = range(0, self._cells.size, CHUNK)
        self._crc32 = [[0] * len(self._starts) for _ in store.source.channels]
        self._files = [folder / store.path(i).name for i in range(len(self._crc32))]

    def fill(self) -> None:
        """Write every value of every file."""
        for path in self._files:
            _allocate(path, self._cells.size * self._store.members)
        if isinstance(self._source, TabulatedSource):
            self._fill_by_member(self._source)
        else:
            self._each(self._starts, self._evaluate_rows, "building columns of")

    def write_manifest(self) -> None:
        """Write down what the files are, for `intact` to compare."""
        files = [
            {
                "size": path.stat().st_size,
                "mtime_ns": path.stat().st_mtime_ns,
                "crc32": crc32,
            }
            for path, crc32 in zip(self._files, self._crc32, strict=True)
        ]
        record = {"source": self._source.name, "columns": self._store.facts, "files": files}
        (self._files[0].parent / MANIFEST).write_text(json.dumps(record))

    def _evaluate_rows(self, start: int) -> None:
        wi, wo = self._store.grid.directions(self._cells[start : start + CHUNK])
        values = self._source.evaluate(wi, wo, np.arange(self._store.members))
        for channel in range(len(self._files)):
            self._write(channel, start, _log(values[:, :, channel]))

    def _fill_by_member(self, source: TabulatedSource) -> None:
        """Read each table once, then turn (members, cells) into (cells, members)."""
        by_member = [path.with_suffix(".members") for path in self._files]
        for path in by_member:
            _allocate(path, self._cells.size * self._store.members)

        def read(member: int) -> None:
            values = source.cell_values(member, self._store.grid, self._cells)
            for channel, path in enumerate(by_member):
                _put(path, member * self._cells.size, _log(values[:, channel]))

        def turn(start: int) -> None:
            count = min(CHUNK, self._cells.size - start)
            for channel, path in enumerate(by_member):
                rows = np.empty((self._store.members, count), dtype=FLOAT)
                for member in range(self._store.members):
                    offset = (member * self._cells.size + start) * FLOAT.itemsize
                    rows[member] = np.fromfile(path, FLOAT, count, offset=offset)
                self._write(channel, start, np.ascontiguousarray(rows.T))

        self._each(range(self._store.members), read, "reading tables of")
        self._each(self._starts, turn, "building columns of")
        for path in by_member:
            path.unlink()

    def _write(self, channel: int, start: int, logs: FloatArray) -> None:
        _put(self._files[channel], start * self._store.members, logs)
        self._crc32[channel][start // CHUNK] = zlib.crc32(logs.data)

    def _each(self, items: range, task: Callable[[int], None], label: str) -> None:
        """Run `task` for each item on all processors; the caller's thread hears of progress."""
        label = f"{label} {self._source.name}"
        self._progress(label, 0, len(items))
        with ThreadPoolExecutor(_workers()) as pool:
            futures = [pool.submit(task, item) for item in items]
            try:
                for done, future in enumerate(as_completed(futures), start=1):
                    future.result()
                    self._progress(label, done, len(items))
            except BaseException:
                pool.shutdown(wait=True, cancel_futures=True)
                raise


def _workers() -> int:
    return max(1, min(_WORKERS, os.cpu_count() or 1))


def _log(values: FloatArray) -> FloatArray:
    logs = np.maximum(values, VALUE_FLOOR, dtype=FLOAT)
    return np.asarray(np.log(logs, out=logs))


def _allocate(path: Path, count: int) -> None:
    with open(path, "wb") as stream:
        stream.truncate(count * FLOAT.itemsize)


def _put(path: Path, position: int, values: FloatArray) -> None:
    with open(path, "r+b") as stream:
        stream.seek(position * FLOAT.itemsize)
        stream.write(values.data)
