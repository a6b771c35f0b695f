"""Environment maps from files: OpenEXR and Radiance's `.hdr`."""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, DataQualityWarning, FormatError, UnknownFormat
from brdfit.formats.exr_file import MAGIC, MOST_PIXELS, read_exr
from brdfit.render import Environment

__all__ = ["read_environment"]

_RGBE = (b"#?RADIANCE", b"#?RGBE")
_RESOLUTION = re.compile(rb"^-Y +(\d{1,6}) +\+X +(\d{1,6})\s*$")
# Rows of the packed kind begin with these, then the width in two bytes.
_PACKED = 2
_LONGEST_PACKED, _SHORTEST_PACKED = 32767, 8


def read_environment(
    path: Path, turned: float = 0.0, *, most_pixels: int = MOST_PIXELS
) -> Environment:
    """Return the panorama of a file, `turned` degrees to the right.

    Linear sRGB; the content tells the format. What is negative or not finite becomes 0, with a
    `DataQualityWarning` that counts the pixels; another one if the width is not twice the
    height. Raises `FormatError` and its kin for the file, also where its header claims more
    than `most_pixels`; `UsageError` for a black one.
    """
    try:
        with path.open("rb") as stream:
            head = stream.read(16)
    except OSError as error:
        raise FormatError(f"{path}: cannot be read: {error.strerror or error}.") from error
    if head.startswith(MAGIC):
        radiance = _exr(path, most_pixels)
    elif head.startswith(_RGBE):
        radiance = _hdr(path, most_pixels)
    else:
        raise UnknownFormat(
            f"{path.name}: is neither OpenEXR nor Radiance .hdr by its content. An environment "
            f"is an equirectangular panorama in one of the two."
        )
    height, width = radiance.shape[:2]
    wrong = ~(np.isfinite(radiance) & (radiance >= 0.0))
    if wrong.any():
        warnings.warn(
            f"{path.name}: {int(wrong.any(axis=2).sum())} of {height * width} pixels are negative "
            f"or not finite in some channel; they were set to 0 there.",
            DataQualityWarning,
            stacklevel=2,
        )
        radiance = np.where(wrong, 0.0, radiance)
    if width != 2 * height:
        warnings.warn(
            f"{path.name}: is {width} x {height} pixels, but an equirectangular panorama is twice "
            f"as wide as high; it is stretched to the sphere as it is.",
            DataQualityWarning,
            stacklevel=2,
        )
    return Environment(path.name, radiance, math.radians(turned))


def _exr(path: Path, most_pixels: int) -> FloatArray:
    planes, _ = read_exr(path, most_pixels)
    names = next((n for n in (("R", "G", "B"), ("Y",) * 3) if set(n) <= set(planes)), None)
    if names is None:
        raise FormatError(
            f"{path.name}: has the channels {', '.join(planes)}, but an environment has R, G and "
            f"B, or Y."
        )
    with np.errstate(invalid="ignore"):  # a NaN is counted, and no warning of NumPy's
        return np.stack([planes[name] for name in names], axis=-1).astype(np.float64)


def _hdr(path: Path, most_pixels: int) -> FloatArray:
    content = path.read_bytes()
    header, _, rest = content.partition(b"\n\n")
    resolution, _, data = rest.partition(b"\n")
    found = _RESOLUTION.match(resolution)
    if found is None:
        raise CorruptFile(
            f"{path.name}: found the resolution line {resolution[:40]!r}, but expected "
            f"'-Y height +X width'. Other orders of rows are not read; convert the file."
        )
    if b"32-bit_rle_xyze" in header:
        raise FormatError(f"{path.name}: holds XYZ colours; convert it to RGB with ra_xyze -r.")
    height, width = int(found[1]), int(found[2])
    if not 0 < height * width <= most_pixels:
        raise CorruptFile(
            f"{path.name}: the header claims {width} x {height} pixels; 1 to {most_pixels:,} are "
            f"read. Make it smaller, or copy it again."
        )
    pixels = np.frombuffer(data, np.uint8)
    try:
        return _decoded(_rows(pixels, height, width))
    except (IndexError, ValueError) as error:
        raise CorruptFile(
            f"{path.name}: ends or breaks off within its {width} x {height} pixels. Copy it again."
        ) from error


def _rows(data: npt.NDArray[np.uint8], height: int, width: int) -> npt.NDArray[np.uint8]:
    """Return (height, width, 4): red, green, blue, exponent."""
    packed = _SHORTEST_PACKED <= width <= _LONGEST_PACKED and data[:2].tolist() == [_PACKED] * 2
    if not packed:
        return data[: height * width * 4].reshape(height, width, 4)
    rows, at = [], 0
    for _ in range(height):
        if data[at : at + 4].tolist() != [_PACKED, _PACKED, width >> 8, width & 255]:
            raise ValueError("a row begins otherwise")
        row, at = _unpacked(data, at + 4, 4 * width)
        rows.append(row.reshape(4, width).T)
    return np.stack(rows)


def _unpacked(
    data: npt.NDArray[np.uint8], at: int, length: int
) -> tuple[npt.NDArray[np.uint8], int]:
    """Return `length` bytes of runs that start at `at`, and where they end."""
    parts, count = [], 0
    while count < length:
        size = int(data[at])
        if size > 128:
            size -= 128
            parts.append(np.repeat(data[at + 1 : at + 2], size))
            at += 2
        else:
            parts.append(data[at + 1 : at + 1 + size])
            at += 1 + size
        if size == 0 or parts[-1].size != size:
            raise ValueError("a run of no length, or beyond the end")
        count += size
    if count != length:
        raise ValueError("a run beyond its row")
    return np.concatenate(parts), at


def _decoded(rgbe: npt.NDArray[np.uint8]) -> FloatArray:
    exponent = rgbe[..., 3:].astype(np.int64)
    value = np.ldexp(rgbe[..., :3] + 0.5, exponent - (128 + 8))
    return np.asarray(np.where(exponent == 0, 0.0, value))
