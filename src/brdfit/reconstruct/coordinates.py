"""Coordinates of direction pairs in which a BRDF is about equally smooth everywhere."""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["half_diff_features"]


def half_diff_features(
    theta_h: FloatArray,
    theta_d: FloatArray,
    phi_d: FloatArray,
    radius: FloatArray | None = None,
) -> FloatArray:
    """Return coordinates (n, 4) in which nearby points are nearby directions.

    (sqrt(theta_h / (pi/2)), theta_d / (pi/2), r cos 2 phi_d, r sin 2 phi_d) with
    r = sin theta_h sin theta_d, or `radius` (n,): reciprocity (phi_d + pi) changes nothing, and
    at the poles, where phi_d has no meaning, neither does phi_d.
    """
    r = np.sin(theta_h) * np.sin(theta_d) if radius is None else radius
    return np.stack(
        [
            np.sqrt(theta_h / (np.pi / 2)),
            theta_d / (np.pi / 2),
            r * np.cos(2.0 * phi_d),
            r * np.sin(2.0 * phi_d),
        ],
        axis=-1,
    )
