"""What is computed once and kept: the user's cache folder, and small arrays by content.

The folder is the platform's own place for caches, or the one that the environment variable
BRDFIT_CACHE names. Everything in it can be removed at any time; it is built again.
"""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from brdfit.errors import PopulationError
from brdfit.files import atomic_path, sha256_of_bytes

__all__ = ["CACHE_VARIABLE", "cache_folder", "locked", "remember"]

CACHE_VARIABLE = "BRDFIT_CACHE"
"""Environment variable that moves the cache folder."""

_KEY = "__key__"

Arrays = dict[str, npt.NDArray[Any]]


def cache_folder(*parts: str) -> Path:
    """Return (and make) a folder of the cache.

    Raises `PopulationError` where it cannot be made.
    """
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        base = Path(named).expanduser()
    else:
        import platformdirs

        base = Path(platformdirs.user_cache_dir("brdfit", appauthor=False))
    folder = base.joinpath(*parts)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PopulationError(
            f"{folder}: the cache folder cannot be made ({error.strerror}). Name a folder that "
            f"can be written to in the environment variable {CACHE_VARIABLE}."
        ) from error
    return folder


@contextmanager
def locked(target: Path) -> Iterator[None]:
    """Hold the lock that belongs to `target`, so that one process at a time builds it."""
    from filelock import FileLock

    with FileLock(target.with_name(target.name + ".lock")):
        yield


def remember(kind: str, key: str, build: Callable[[], Arrays]) -> Arrays:
    """Return the arrays that `build()` gives, computed once for each `kind` and `key`.

    `key` is all that determines the arrays (fingerprints, settings, a version of the code),
    of any length; `kind` is a word that names the subfolder. Two processes that ask at once
    build once. An entry that is damaged, or belongs to another key, is built again.
    """
    path = cache_folder("arrays", kind) / f"{sha256_of_bytes(key.encode())[:32]}.npz"
    found = _read(path, key)
    if found is not None:
        return found
    with locked(path):
        found = _read(path, key)
        if found is not None:
            return found
        arrays = {name: np.asarray(array) for name, array in build().items()}
        with atomic_path(path) as aside, open(aside, "wb") as stream:
            keyed: dict[str, Any] = {_KEY: np.array(key), **arrays}
            np.savez(stream, **keyed)
        return arrays


def _read(path: Path, key: str) -> Arrays | None:
    # The archive carries a checksum of each array, so that damage shows when it is read.
    broken = (
        OSError,
        ValueError,
        KeyError,
        EOFError,
        AttributeError,
        zipfile.BadZipFile,
        zlib.error,
    )
    with suppress(*broken), open(path, "rb") as stream:
        entry = np.load(stream, allow_pickle=False)
        arrays = {name: entry[name] for name in entry.files}
        if str(arrays.pop(_KEY)) == key:
            return arrays
    return None
