"""A user's environment map: a panorama read from a file, as lights."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, MissingExtra, UsageError
from brdfit.render.illumination import Illumination
from brdfit.render.panorama import panorama_lights
from brdfit.tone import srgb_decode

__all__ = ["environment_from", "read_panorama"]

_MOST_PIXELS = 1 << 25


def environment_from(path: Path) -> Illumination:
    """Return the lights of a panorama file; `FormatError` for what cannot be read."""
    return panorama_lights(read_panorama(path), path.name)


def read_panorama(path: Path) -> FloatArray:
    """Return linear sRGB (height, width, 3) of an .exr, .png or .jpg file."""
    suffix = path.suffix.lower()
    if suffix == ".exr":
        return _read_exr(path)
    if suffix in (".png", ".jpg", ".jpeg"):
        return _read_picture(path)
    raise UsageError(f"{path.name}: found {suffix!r} but a panorama is .exr, .png or .jpg.")


def _read_exr(path: Path) -> FloatArray:
    try:
        import OpenEXR
    except ImportError as error:
        raise MissingExtra("OpenEXR", "exr", "an environment map in .exr") from error
    try:
        with OpenEXR.File(str(path)) as file:
            channels = file.channels()
            found = channels.get("RGB") or channels.get("RGBA")
            if found is None:
                raise ValueError(f"channels {', '.join(channels)}, not R, G, B")
            return np.asarray(found.pixels[..., :3], dtype=np.float64)
    except (RuntimeError, ValueError, TypeError, OSError) as error:
        raise CorruptFile(f"{path.name}: cannot be read as OpenEXR ({error}).") from error


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
