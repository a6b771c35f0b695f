"""Where the numbers of a UTIA file stand.

Three planes, R, G, B; in each the number of (theta_i, phi_i, theta_v, phi_v) at flat index
phi_v + 48 (theta_v + 6 (phi_i + 48 theta_i)); no header, little-endian.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_spherical

__all__ = ["CONVENTION", "FILE_BYTES", "PHIS", "SHAPE", "THETAS", "directions"]

THETAS, PHIS = 6, 48
"""Polar angles and azimuths, of the light and of the detector alike."""

SHAPE = (3, THETAS * PHIS, THETAS * PHIS)
"""Planes, directions of the light, directions of the detector."""

FILE_BYTES = {"<f8": int(np.prod(SHAPE)) * 8, "<f4": int(np.prod(SHAPE)) * 4}
"""Type of the numbers -> bytes of a file: 1,990,656 and 995,328."""

CONVENTION = (
    "theta_i phi_i toward the light, theta_v phi_v toward the detector, each 0 to 75 degrees in "
    "steps of 15 and 0 to 352.5 in steps of 7.5, azimuths in the frame of the sample; values are "
    "f_r, linear sRGB, times what encoding, white and scale say"
)


def directions() -> FloatArray:
    """Return the unit vectors (288, 3) of both the light and the detector, in order."""
    theta = np.deg2rad(15.0 * np.arange(THETAS))
    phi = np.deg2rad(7.5 * np.arange(PHIS))
    return directions_from_spherical(theta[:, None], phi[None, :]).reshape(-1, 3)
