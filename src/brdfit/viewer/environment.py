"""A user's environment map: a panorama read from a file, as lights."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, UnknownFormat
from brdfit.render.illumination import Illumination
from brdfit.render.panorama import panorama_lights
from brdfit.report.environment_file import read_environment
from brdfit.tone import srgb_decode

__all__ = ["environment_from", "read_panorama"]

# What is decoded lies in memory at 24 bytes a pixel.
_MOST_PIXELS = 1 << 25
_PICTURES = (".png", ".jpg", ".jpeg")


def environment_from(path: Path) -> Illumination:
    """Return the lights of a panorama file; `FormatError` for what cannot be read."""
    return panorama_lights(read_panorama(path), path.name)


def read_panorama(path: Path) -> FloatArray:
    """Return linear sRGB (height, width, 3) of an .exr, .hdr, .png or .jpg file.

    Of the first two the content tells, and `DataQualityWarning` what had to be left out.
    """
    if path.suffix.lower() in _PICTURES:
        return _read_picture(path)
    try:
        return read_environment(path, most_pixels=_MOST_PIXELS).radiance
    except UnknownFormat as error:
        raise UnknownFormat(
            f"{path.name}: found {path.suffix!r} but a panorama is OpenEXR (.exr), Radiance "
            f"(.hdr), .png or .jpg."
        ) from error


def _read_picture(path: Path) -> FloatArray:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            if picture.width * picture.height > _MOST_PIXELS:
                raise CorruptFile(
                    f"{path.name}: has {picture.width} x {picture.height} pixels, more than the "
                    f"{_MOST_PIXELS:,} that are read. Make it smaller."
                )
            pixels = np.asarray(picture.convert("RGB"), dtype=np.float64) / 255.0
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise CorruptFile(f"{path.name}: cannot be read as a picture ({error}).") from error
    return srgb_decode(pixels)
