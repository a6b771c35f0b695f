"""Reading arrays out of an archive that may be damaged or hostile.

Every size that an archive declares is held against what is there, and against a limit,
before memory is taken for it. Nothing is ever unpickled.
"""

from __future__ import annotations

import math
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from brdfit.errors import CorruptFile

__all__ = ["MOST_BYTES", "Archive", "open_archive"]

MOST_BYTES = 1 << 31
"""What the compressed members of one archive may unpack to, together: 2 GiB."""

_SUFFIX = ".npy"
_LONGEST_ARRAY_HEADER = 10_000

# What the standard library raises for damaged members, encrypted ones included.
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    ValueError,
    RuntimeError,
    LookupError,
    OSError,
    # NumPy parses the header of an array as Python, and lets through what that says
    SyntaxError,
    tokenize.TokenError,
)


class Archive:
    """The arrays of an open archive by name."""

    def __init__(self, archive: zipfile.ZipFile, name: str, size: int) -> None:
        self._archive = archive
        self.name = name
        """Name of the file, for messages."""
        self.members = _checked_members(archive, name, size)
        """Array name -> zip entry."""

    def array(self, member: str) -> npt.NDArray[Any]:
        """Return one array, read-only; `CorruptFile` if it is not what it declares."""
        info = self.members[member]
        try:
            with self._archive.open(info) as stream:
                shape, fortran, dtype = _array_header(stream)
                count = self._checked_count(member, shape, dtype, info.file_size - stream.tell())
                content = stream.read(count * dtype.itemsize)
                # one read more: the checksum is compared at the end of the member
                complete = len(content) == count * dtype.itemsize and not stream.read(1)
        except _DAMAGE as error:
            raise CorruptFile(
                f"{self.name}: the array {member!r} is damaged ({error}). Write or copy the file "
                f"again."
            ) from error
        if not complete:
            raise CorruptFile(
                f"{self.name}: the array {member!r} of shape {shape} has {len(content):,} bytes "
                f"but {count * dtype.itemsize:,} were expected. The file is damaged."
            )
        flat = np.frombuffer(content, dtype, count) if count else np.empty(0, dtype)
        return flat.reshape(shape, order="F" if fortran else "C")

    def _checked_count(
        self, member: str, shape: tuple[int, ...], dtype: np.dtype[Any], room: int
    ) -> int:
        if dtype.hasobject or dtype.kind not in "biuf":
            raise CorruptFile(
                f"{self.name}: the array {member!r} has the type {dtype} but only plain numbers "
                f"are read."
            )
        count = math.prod(shape)
        if any(size < 0 for size in shape) or count * dtype.itemsize != room:
            raise CorruptFile(
                f"{self.name}: the array {member!r} declares the shape {shape} of {dtype}, "
                f"{count * dtype.itemsize:,} bytes, but the archive has {room:,} for it."
            )
        return count


@contextmanager
def open_archive(path: Path) -> Iterator[Archive]:
    """Open a zip archive of arrays; `CorruptFile` if it is none, or declares absurd sizes."""
    try:
        archive = zipfile.ZipFile(path)
    except (zipfile.BadZipFile, ValueError, LookupError, RuntimeError) as error:
        raise CorruptFile(
            f"{path.name}: is not a complete zip archive, which an .npz must be ({error}). It "
            f"looks truncated; write or copy it again."
        ) from error
    with archive:
        yield Archive(archive, path.name, path.stat().st_size)


def _checked_members(archive: zipfile.ZipFile, name: str, size: int) -> dict[str, zipfile.ZipInfo]:
    members: dict[str, zipfile.ZipInfo] = {}
    unpacked = 0
    for info in archive.infolist():
        member = info.filename.removesuffix(_SUFFIX)
        if member in members:
            raise CorruptFile(f"{name}: the array {member!r} occurs twice.")
        members[member] = info
        if info.compress_size > size:
            raise CorruptFile(
                f"{name}: the array {member!r} declares {info.compress_size:,} bytes in the "
                f"archive but the file has {size:,}. The file is damaged."
            )
        if info.compress_type == zipfile.ZIP_STORED:
            if info.file_size != info.compress_size:
                raise CorruptFile(
                    f"{name}: the array {member!r} is not compressed but declares "
                    f"{info.file_size:,} bytes in {info.compress_size:,}. The file is damaged."
                )
        else:
            unpacked += info.file_size
    if unpacked > MOST_BYTES:
        raise CorruptFile(
            f"{name}: has {size:,} bytes but declares to unpack to {unpacked:,}, more than the "
            f"{MOST_BYTES:,} that are read. If that is right, write it without compression."
        )
    return members


def _array_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(stream)
    with warnings.catch_warnings():
        # NumPy takes a damaged header for one of Python 2
        warnings.simplefilter("ignore", UserWarning)
        if version == (1, 0):
            return np.lib.format.read_array_header_1_0(stream, _LONGEST_ARRAY_HEADER)
        if version == (2, 0):
            return np.lib.format.read_array_header_2_0(stream, _LONGEST_ARRAY_HEADER)
    raise ValueError(f"array format version {version[0]}.{version[1]} is not known")
