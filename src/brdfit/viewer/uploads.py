"""Files that come in over the network: never more than the limit, never what only looks small."""

from __future__ import annotations

import re
import tempfile
import zipfile
from pathlib import Path

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request

from brdfit.errors import BrdfitError, CorruptFile, UsageError

__all__ = ["TooLarge", "body_within", "checked_archive", "receive_file"]

_MOST_UNPACKED = 1 << 29
"""Bytes that an uploaded archive may unpack to: four times a MERL table of 16 channels."""
_MOST_NUMBERS = 1 << 27
"""Numbers that an uploaded Parquet file may hold."""
_STRANGE = re.compile(r"[^\w.+ ()-]", re.ASCII)
_LONGEST_NAME = 120


class TooLarge(BrdfitError):
    """More came in than the limit allows."""


async def receive_file(request: Request, folder: Path, name: str, limit: int) -> Path:
    """Write the body of a request to a file of its own folder in `folder`; return its path.

    The file keeps the last part of `name`, since readers look at the suffix and reports say
    the name. Raises `TooLarge` as soon as more than `limit` bytes come or are announced,
    `CorruptFile` for an archive that unpacks to far more than its size. What was refused
    leaves nothing behind.
    """
    path = Path(tempfile.mkdtemp(dir=folder)) / _plain(name)
    try:
        with path.open("wb") as stream:
            async for block in _blocks(request, limit):
                await run_in_threadpool(stream.write, block)
        await run_in_threadpool(checked_archive, path)
    except BaseException:
        path.unlink(missing_ok=True)
        path.parent.rmdir()
        raise
    return path


async def body_within(request: Request, limit: int) -> bytes:
    """Return the body of a request of at most `limit` bytes; `TooLarge` otherwise."""
    return b"".join([block async for block in _blocks(request, limit)])


async def _blocks(request: Request, limit: int):  # type: ignore[no-untyped-def]
    announced = request.headers.get("content-length", "0")
    if announced.isdecimal() and int(announced) > limit:
        raise TooLarge(_too_large(limit))
    received = 0
    async for block in request.stream():
        received += len(block)
        if received > limit:
            raise TooLarge(_too_large(limit))
        yield block


def _too_large(limit: int) -> str:
    return (
        f"the file is larger than the {limit >> 20} MB that are taken over the network. Open it "
        f"with brdfit view FILE instead."
    )


def _plain(name: str) -> str:
    """Return the last part of a name without anything that could mean a path."""
    last = re.split(r"[\\/]", name)[-1]
    plain = _STRANGE.sub("_", last).strip(". ")
    if not plain:
        raise UsageError(f"name: found {name!r} but the name of a file was expected.")
    stem, dot, suffix = plain.rpartition(".")
    return (stem[-_LONGEST_NAME:] + dot + suffix[:20]) if dot else plain[-_LONGEST_NAME:]


def checked_archive(path: Path) -> None:
    """Raise `CorruptFile` for an archive or Parquet file that would unpack beyond reason."""
    with path.open("rb") as stream:
        magic = stream.read(4)
    if magic == b"PAR1":
        _check_parquet(path)
    elif magic[:2] == b"PK":
        _check_zip(path)


def _check_zip(path: Path) -> None:
    try:
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(info.file_size for info in archive.infolist())
    except (zipfile.BadZipFile, ValueError, LookupError, RuntimeError, OSError) as error:
        raise CorruptFile(f"{path.name}: is not a complete zip archive ({error}).") from error
    if unpacked > _MOST_UNPACKED:
        raise CorruptFile(
            f"{path.name}: has {path.stat().st_size:,} bytes but would unpack to {unpacked:,}, "
            f"more than the {_MOST_UNPACKED:,} that are taken over the network. If that is "
            f"right, open it with brdfit view FILE."
        )


def _check_parquet(path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        metadata = parquet.ParquetFile(path).metadata
        numbers = int(metadata.num_rows) * int(metadata.num_columns)
    except (pa.ArrowException, OSError) as error:
        raise CorruptFile(f"{path.name}: is not a complete Parquet file ({error}).") from error
    if numbers > _MOST_NUMBERS:
        raise CorruptFile(
            f"{path.name}: declares {numbers:,} numbers, more than the {_MOST_NUMBERS:,} that are "
            f"taken over the network. If that is right, open it with brdfit view FILE."
        )
