"""Pixels of an OpenEXR file, through the library of its owners."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, MissingExtra

__all__ = ["MAGIC", "MOST_PIXELS", "read_exr", "require_openexr", "write_exr"]

MAGIC = b"\x76\x2f\x31\x01"
MOST_PIXELS = 1 << 27
"""Bigger pictures are refused before a byte is allocated for them."""


def require_openexr(purpose: str) -> ModuleType:
    """Return the library, or raise `MissingExtra` for `purpose`."""
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtra("OpenEXR", "exr", purpose) from error
    module: ModuleType = OpenEXR
    return module


def read_exr(
    path: Path, most_pixels: int = MOST_PIXELS
) -> tuple[dict[str, FloatArray], dict[str, Any]]:
    """Return ({channel: (height, width) float64}, header) of the first part of a file.

    R, G and B are three channels. Raises `CorruptFile` for what the library refuses, and for
    headers that claim more pixels than any picture has.
    """
    library = require_openexr(f"Reading {path.name}")
    try:
        file = library.File(str(path), separate_channels=True, header_only=True)
        header = dict(file.header())
        low, high = (np.asarray(corner, dtype=np.int64) for corner in header["dataWindow"])
        extent = high - low + 1
        if (extent < 1).any() or int(extent[0]) * int(extent[1]) > most_pixels:
            raise CorruptFile(
                f"{path.name}: the header claims {extent[0]} x {extent[1]} pixels, more "
                f"than the {most_pixels:,} that are read. Make it smaller, or copy it again."
            )
        channels = library.File(str(path), separate_channels=True).channels()
        return {name: _plane(one.pixels) for name, one in channels.items()}, header
    except CorruptFile:
        raise
    except Exception as error:  # the library raises whatever its C++ does
        raise CorruptFile(
            f"{path.name}: OpenEXR cannot read it ({error}). The file is damaged; export it again."
        ) from error


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


def _plane(pixels: Any) -> FloatArray:
    plane = np.asarray(pixels, dtype=np.float64)
    if plane.ndim != 2:
        raise ValueError(f"a channel of shape {plane.shape}")
    return plane
