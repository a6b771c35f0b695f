"""Large matrices that are worked out once and read from disk: rows of float32, by content."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import PopulationError
from brdfit.files import atomic_path, sha256_of_bytes
from brdfit.populations.cache import cache_folder, locked

__all__ = ["remember_rows"]


def remember_rows(
    kind: str, key: str, shape: tuple[int, int], blocks: Callable[[], Iterator[FloatArray]]
) -> FloatArray:
    """Return the matrix whose rows `blocks()` yields in order, float32, read from disk as asked.

    `key` is all that determines the rows. Two processes that ask at once build once; the file
    appears when it is complete. Raises `PopulationError` where the disk has no room for it.
    """
    path = cache_folder(kind) / f"{sha256_of_bytes(key.encode())[:24]}.npy"
    with locked(path):
        if not path.exists():
            _need_room(str(path.parent), 4 * shape[0] * shape[1])
            with atomic_path(path) as aside, open(aside, "wb") as stream:
                header = {"descr": "<f4", "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_1_0(stream, header)
                for block in blocks():
                    stream.write(np.ascontiguousarray(block, dtype="<f4").data)
        status = path.stat()
    return _mapped(str(path), status.st_ino, status.st_mtime_ns)


@lru_cache(maxsize=4)
def _mapped(path: str, *identity: int) -> FloatArray:
    """Return what is on disk, mapped; the same mapping again while the file is the same."""
    return np.asarray(np.load(path, mmap_mode="r"))


def _need_room(folder: str, size: int) -> None:
    free = shutil.disk_usage(folder).free
    if free < size + (64 << 20):
        raise PopulationError(
            f"{folder}: the principal components need {size >> 20} MB but {free >> 20} MB are "
            f"free. Make room, or name another folder in BRDFIT_CACHE."
        )
