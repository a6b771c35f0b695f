"""The unit square and the unit disk, after Shirley and Chiu, and the directions above it.

Concentric squares become concentric circles, so that equal areas stay equal. The projection of
a direction onto the disk makes equal areas equal projected solid angles.

Reference: P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and Square", Journal of
Graphics Tools 2(3), 1997.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["directions_of"]


def directions_of(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return unit vectors (..., 3) with z >= 0 of points of the unit square."""
    a, b = 2.0 * np.asarray(x) - 1.0, 2.0 * np.asarray(y) - 1.0
    wide = np.abs(a) > np.abs(b)
    r = np.where(wide, a, b)
    # r carries a sign, which turns by pi
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(wide, b / a, a / b)
    ratio = np.where(r == 0.0, 0.0, ratio)
    phi = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    z = np.sqrt(np.maximum(1.0 - r * r, 0.0))
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)
