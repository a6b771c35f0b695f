"""Pixels of an OpenEXR file, through the library of its owners."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, MissingExtra

__all__ = ["MAGIC", "MOST_PIXELS", "read_exr", "read_exr_header", "require_openexr", "write_exr"]

MAGIC = b"\x76\x2f\x31\x01"
MOST_PIXELS = 1 << 27
"""Bigger pictures are refused before a byte is allocated for them."""
_MOST_NUMBERS = 1 << 29
# Pixels in a byte: an even picture packs to a few bytes for each 32 lines. The library sets all
# memory aside before it reads, and keeps it where it fails.
_MOST_PACKED = 1 << 15
_MOST_HEADER = 1 << 24
# Type, linearity and sampling, after the name of a channel.
_CHANNEL_BYTES = 16


def require_openexr(purpose: str) -> ModuleType:
    """Return the library, or raise `MissingExtra` for `purpose`."""
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtra("OpenEXR", "exr", purpose) from error
    module: ModuleType = OpenEXR
    return module


def read_exr_header(path: Path, most_pixels: int = MOST_PIXELS) -> dict[str, Any]:
    """Return the header of the first part of a file, its pixels unread.

    Raises `CorruptFile` for what the library refuses, and for headers that claim more than
    `most_pixels`, or more channels of them than a picture has.
    """
    library = require_openexr(f"Reading {path.name}")
    try:
        _check_names(path)
        file = library.File(str(path), separate_channels=True, header_only=True)
        header = dict(file.header())
        low, high = (np.asarray(corner, dtype=np.int64) for corner in header["dataWindow"])
        planes = max(len(header["channels"]), 1)
    except Exception as error:  # the library raises whatever its C++ does
        raise _unreadable(path, error) from error
    extent = high - low + 1
    pixels = int(extent[0]) * int(extent[1])
    if pixels * planes > path.stat().st_size * _MOST_PACKED:
        raise CorruptFile(
            f"{path.name}: the header claims {planes} channels of {extent[0]} x {extent[1]} "
            f"pixels, which {path.stat().st_size:,} bytes cannot hold. The file is damaged or "
            f"truncated; copy it again."
        )
    if (extent < 1).any() or pixels > most_pixels or pixels * planes > _MOST_NUMBERS:
        raise CorruptFile(
            f"{path.name}: the header claims {planes} channels of {extent[0]} x {extent[1]} "
            f"pixels, more than the {most_pixels:,} that are read. Make it smaller, or copy it "
            f"again."
        )
    return header


def read_exr(
    path: Path, most_pixels: int = MOST_PIXELS
) -> tuple[dict[str, FloatArray], dict[str, Any]]:
    """Return ({channel: (height, width) float32}, header) of the first part of a file.

    R, G and B are three channels. Errors as of `read_exr_header`.
    """
    header = read_exr_header(path, most_pixels)
    library = require_openexr(f"Reading {path.name}")
    low, high = (np.asarray(corner, dtype=np.int64) for corner in header["dataWindow"])
    width, height = (int(size) for size in high - low + 1)
    single = _single_precision(path)
    try:
        # not `File`, which answers for damaged pixels with a word on the standard output
        file = library.InputFile(str(path))
        planes = {
            name: np.frombuffer(file.channel(name, single), np.float32)
            for name in file.header()["channels"]
        }
    except Exception as error:  # the library raises whatever its C++ does
        raise _unreadable(path, error) from error
    for name, plane in planes.items():
        if plane.size != height * width:
            raise CorruptFile(
                f"{path.name}: the channel {name!r} has {plane.size} pixels where {width} x "
                f"{height} were expected; channels of other resolutions are not read."
            )
    return {name: plane.reshape(height, width) for name, plane in planes.items()}, header


def _single_precision(path: Path) -> object:
    """Return what `InputFile` takes for float32; the module comes with the library."""
    try:
        return import_module("Imath").PixelType(2)
    except ImportError as error:
        raise MissingExtra("OpenEXR", "exr", f"Reading {path.name}") from error


def _check_names(path: Path) -> None:
    """Raise `ValueError` for names of attributes and channels that are no text.

    The library's binding ends the whole process where a channel has such a name.
    """
    with path.open("rb") as stream:
        content = stream.read(_MOST_HEADER)
    at, several_parts = 8, bool(content[5:6] and content[5] & 0x10)
    while True:
        name, at = _word(content, at)
        if not name:
            if several_parts and content[at : at + 1] != b"\0":
                continue
            return
        kind, at = _word(content, at)
        size = int.from_bytes(content[at : at + 4], "little")
        value, at = content[at + 4 : at + 4 + size], at + 4 + size
        if len(value) < size:
            raise ValueError(f"the attribute {name!r} goes beyond the end")
        if kind == "chlist":
            place = 0
            while value[place : place + 1] not in (b"\0", b""):
                _, place = _word(value, place)
                place += _CHANNEL_BYTES


def _word(content: bytes, start: int) -> tuple[str, int]:
    """Return the text that ends with the next zero byte, and where the next one begins."""
    end = content.find(b"\0", start)
    if end < 0:
        raise ValueError("the header does not end")
    return content[start:end].decode("utf-8"), end + 1


def _unreadable(path: Path, error: Exception) -> CorruptFile:
    return CorruptFile(
        f"{path.name}: OpenEXR cannot read it ({error}). The file is damaged; export it again."
    )


def write_exr(planes: Mapping[str, FloatArray], header: Mapping[str, str], path: Path) -> None:
    """Write float32 planes (height, width), compressed without loss; `path` is written at once."""
    library = require_openexr(f"Writing {path.name}")
    whole = {
        "compression": library.ZIP_COMPRESSION,
        "type": library.scanlineimage,
        **header,
    }
    pixels = {name: np.ascontiguousarray(plane, np.float32) for name, plane in planes.items()}
    library.File(whole, pixels).write(str(path))
