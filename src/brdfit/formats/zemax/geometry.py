"""Directions of Zemax's angles, which are counted from the specular direction.

The light is at incidence I and azimuth 180 degrees, the specular direction s at azimuth 0:

    wi = (-sin I, 0, cos I)      s = (sin I, 0, cos I)
    x' = (-cos I, 0, sin I)      from s toward the normal: ScatterAzimuth 0
    y' = s x x' = (0, -1, 0)     counter-clockwise as seen against s
    wo = cos r s + sin r (cos a x' + sin a y')
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_spherical

__all__ = ["directions_from_specular"]

_HORIZON = 1e-12


def directions_from_specular(
    incidence: FloatArray, azimuth: FloatArray, radial: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return (wi, wo), each (..., 3), of angles in radians that broadcast together."""
    incidence, azimuth, radial = np.broadcast_arrays(incidence, azimuth, radial)
    wi = directions_from_spherical(incidence, np.full(incidence.shape, np.pi))
    sin_i, cos_i = np.sin(incidence), np.cos(incidence)
    toward = np.sin(radial) * np.cos(azimuth)
    height = np.cos(radial) * cos_i + toward * sin_i
    wo = np.stack(
        [
            np.cos(radial) * sin_i - toward * cos_i,
            -np.sin(radial) * np.sin(azimuth),
            # rounding must not lift a direction off the horizon
            np.where(np.abs(height) < _HORIZON, 0.0, height),
        ],
        axis=-1,
    )
    return wi, wo
