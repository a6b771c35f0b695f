"""How far a direction is from the nearest sample, in degrees of half/difference coordinates."""

from __future__ import annotations

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.geometry import wrap_phi_d
from brdfit.samples import Samples

__all__ = ["FAR", "NEAR", "Reach"]

NEAR = 5.0
"""Degrees in half/difference coordinates within which a sample speaks for a direction."""

FAR = 15.0
"""Degrees beyond which a direction is no longer interpolated, but supplied by the method."""


class Reach:
    """How far any direction is from the nearest usable sample.

    Distance is Euclidean in (theta_h, theta_d) and the arc that phi_d spans there, with
    phi_d taken by reciprocity. Without a usable sample every distance is infinite.
    """

    def __init__(self, samples: Samples, among: BoolArray | None = None) -> None:
        """Take the usable samples, or those of the mask `among` (n,) only."""
        from scipy.spatial import cKDTree

        used = samples.usable.any(axis=1)
        used = used if among is None else used & among
        points = _embedded(*(angle[used] for angle in samples.half_diff))
        # Twenty thousand points already fill what hundreds of thousands fill.
        step = max(1, len(points) // 20_000)
        self._tree = cKDTree(points[::step])

    def degrees(
        self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray, most: float = FAR
    ) -> FloatArray:
        """Return the distance, shaped as the angles (radians); infinite beyond `most`."""
        angles = np.broadcast_arrays(theta_h, theta_d, phi_d)
        distance, _ = self._tree.query(
            _embedded(*angles), distance_upper_bound=np.radians(most) * (1.0 + 1e-12)
        )
        return np.asarray(np.degrees(distance))


def _embedded(theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> FloatArray:
    """Points (n, 4) whose distances are angles in radians; phi_d has period pi.

    Turning phi_d by d moves the directions by about min(sin theta_h, sin theta_d) d, and not
    at all at either pole.
    """
    phi = wrap_phi_d(phi_d)
    radius = 0.5 * np.minimum(np.sin(theta_h), np.sin(theta_d))
    return np.stack([theta_h, theta_d, radius * np.cos(2 * phi), radius * np.sin(2 * phi)], axis=-1)
