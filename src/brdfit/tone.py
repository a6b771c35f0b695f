"""From linear light to what a screen shows: exposure, the sRGB curve, the colour library.

Images are linear sRGB arrays (height, width, channels) with 1 or 3 channels, any scale. A
*display* image is (height, width, 3) in [0, 1] with the sRGB curve on it. Nothing here
knows what is in the image.

Reference: IEC 61966-2-1:1999 (sRGB).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import UsageError

__all__ = [
    "LUMINANCE",
    "colour_library",
    "display_image",
    "exposure_scale",
    "srgb_decode",
    "srgb_encode",
    "three_channels",
]

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of linear R, G, B in luminance Y (ITU-R BT.709, the primaries of sRGB)."""

_PERCENTILE = 95.0
_LEVEL = 0.8


def exposure_scale(reference: FloatArray, mask: BoolArray | None = None) -> float:
    """Return the factor that brings the 95th percentile of `reference` to 0.8.

    The percentile is over the pixels inside `mask` (height, width), all channels
    together. Raises `UsageError` for an image that is black or not finite there: no
    factor makes it visible.
    """
    pixels = reference if mask is None else reference[mask]
    level = float(np.percentile(pixels, _PERCENTILE)) if pixels.size else 0.0
    if not (np.isfinite(level) and level > 0.0):
        raise UsageError(
            f"exposure: the 95th percentile of the reference image is {level:g} but it must be "
            f"finite and above zero. Check that the reference holds values where it is looked at."
        )
    return _LEVEL / level


def srgb_encode(linear: FloatArray) -> FloatArray:
    """Return the sRGB curve of linear values, which are clipped to [0, 1] first."""
    c = np.clip(linear, 0.0, 1.0)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1.0 / 2.4) - 0.055)


def srgb_decode(encoded: FloatArray) -> FloatArray:
    """Return the linear values of sRGB-encoded ones in [0, 1]."""
    v = np.clip(encoded, 0.0, 1.0)
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def three_channels(image: FloatArray) -> FloatArray:
    """Return `image` (..., 1 or 3) with three channels: one channel becomes grey."""
    if image.shape[-1] == 3:
        return image
    if image.shape[-1] == 1:
        return np.repeat(image, 3, axis=-1)
    raise UsageError(
        f"image: found {image.shape[-1]} channels but a picture has 1 or 3. Convert spectral "
        f"values with brdfit.render.to_rgb first."
    )


def display_image(linear: FloatArray, scale: float) -> FloatArray:
    """Return (height, width, 3) in [0, 1] with the sRGB curve: `linear` times `scale`, clipped."""
    return srgb_encode(three_channels(linear) * scale)


def colour_library() -> Any:
    """Import colour-science, which takes seconds, and undo what its import changes.

    It sets numpy's legacy print options for the whole process; a library used by other
    people's scripts must not.
    """
    with np.printoptions():
        import colour
    return colour
