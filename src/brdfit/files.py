"""Files that appear whole or not at all, and the hash that names a content.

The only module of the lower floors that touches the disk; the numerical core does
not import it.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from brdfit.errors import UsageError

__all__ = ["atomic_path", "sha256_of_bytes", "sha256_of_file"]

_BLOCK = 1 << 20


@contextmanager
def atomic_path(target: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a path beside `target` to write to; rename it to `target` on success.

    The temporary file carries the suffix of the target, because some writers choose
    the format by it. On any exception, an interrupt included, the temporary file is
    removed and an existing target stays as it was. A link is followed.

    Raises `UsageError` where a file cannot stand: the folder does not exist, or the target
    is a folder or a device.
    """
    target = Path(target).resolve()
    if not target.parent.is_dir():
        raise UsageError(f"{target}: the folder {target.parent} does not exist; create it first.")
    if target.exists() and not target.is_file():
        raise UsageError(f"{target}: found a folder or a device; name a file to write to.")
    handle, name = tempfile.mkstemp(
        prefix=f".{target.stem}.", suffix=f".part{target.suffix}", dir=target.parent
    )
    os.close(handle)
    aside = Path(name)
    try:
        yield aside
        aside.chmod(0o666 & ~_umask())
        os.replace(aside, target)
    except BaseException:
        with suppress(FileNotFoundError):
            aside.unlink()
        raise


def sha256_of_bytes(content: bytes) -> str:
    """Return the SHA-256 of `content` as 64 hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def sha256_of_file(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file, read in blocks of 1 MiB."""
    digest = hashlib.sha256()
    with open(path, "rb") as stream:
        while block := stream.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()


def _umask() -> int:
    # mkstemp makes files private; what a user asked for has the user's usual mode.
    mask = os.umask(0)
    os.umask(mask)
    return mask
