"""Directions <-> half/difference coordinates of an isotropic BRDF.

Directions are unit vectors in the surface frame, normal = +z: `wi` toward the light,
`wo` toward the detector. An isotropic BRDF depends on three angles (Rusinkiewicz 1998),
always in this order and in radians:

    theta_h   angle of the half vector wh from the normal          [0, pi/2]
    theta_d   angle of wi from wh                                   [0, pi/2]
    phi_d     azimuth of wi about wh, 0 = away from the normal      [0, 2 pi)

Exchanging wi and wo (Helmholtz reciprocity) turns phi_d into phi_d + pi, so tables keep
phi_d in [0, pi); `wrap_phi_d` is the one place where that is done. Rotating both directions
about the normal changes nothing.

Reference: S. Rusinkiewicz, "A New Change of Variables for Efficient BRDF Representation",
Rendering Techniques 1998.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, dot, normalize
from brdfit.errors import UsageError

__all__ = [
    "cos_incident_outgoing",
    "directions_from_half_diff",
    "directions_from_spherical",
    "half_diff_from_directions",
    "spherical_from_directions",
    "split_by_horizon",
    "wrap_phi_d",
]

# Below this sine an azimuth is rounding noise of the inputs, not a direction.
_POLE = 1e-7


def directions_from_spherical(theta: FloatArray, phi: FloatArray) -> FloatArray:
    """Return unit vectors (..., 3) at polar angle `theta` and azimuth `phi` (radians).

    A negative `theta` means the opposite azimuth, as some instruments write it.
    """
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    sin_theta = np.sin(theta)
    return np.stack([sin_theta * np.cos(phi), sin_theta * np.sin(phi), np.cos(theta)], axis=-1)


def spherical_from_directions(w: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (theta in [0, pi], phi in (-pi, pi]) of directions (..., 3), in radians."""
    x, y, z = w[..., 0], w[..., 1], w[..., 2]
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def wrap_phi_d(phi_d: FloatArray) -> FloatArray:
    """Bring phi_d (radians) into [0, pi) by reciprocity."""
    wrapped = np.mod(phi_d, np.pi)
    # np.mod of a tiny negative number rounds to pi itself.
    return np.asarray(np.where(wrapped >= np.pi, 0.0, wrapped))


def half_diff_from_directions(
    wi: FloatArray, wo: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (theta_h, theta_d, phi_d) of direction pairs (..., 3).

    phi_d is in [0, 2 pi): it still tells wi from wo. At a pole (theta_h = 0 or
    theta_d = 0) phi_d has no meaning and is returned as 0, so that a rotation of the
    sample about its normal changes none of the three. Two exactly opposite directions
    have no half vector; the normal is taken.
    """
    wi, wo = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wo, float))
    both, apart = wi + wo, wi - wo
    wh = normalize(both)
    opposite = dot(wh, wh) == 0.0
    if np.any(opposite):
        wh = np.where(opposite[..., None], np.array([0.0, 0.0, 1.0]), wh)

    # wi and wo span 2 theta_d: |wi - wo| = 2 sin theta_d, |wi + wo| = 2 cos theta_d
    theta_d = np.arctan2(np.sqrt(dot(apart, apart)), np.sqrt(dot(both, both)))

    # wh = (sin theta_h cos phi_h, sin theta_h sin phi_h, cos theta_h)
    sin_theta_h = np.hypot(wh[..., 0], wh[..., 1])
    cos_theta_h = wh[..., 2]
    at_pole_h = sin_theta_h < _POLE
    safe = np.where(at_pole_h, 1.0, sin_theta_h)
    cos_phi_h = np.where(at_pole_h, 1.0, wh[..., 0] / safe)
    sin_phi_h = np.where(at_pole_h, 0.0, wh[..., 1] / safe)

    # wd = rotation of wi by -phi_h about z, then by -theta_h about y
    along = cos_phi_h * wi[..., 0] + sin_phi_h * wi[..., 1]
    wd_x = cos_theta_h * along - sin_theta_h * wi[..., 2]
    wd_y = cos_phi_h * wi[..., 1] - sin_phi_h * wi[..., 0]

    theta_h = np.arctan2(sin_theta_h, cos_theta_h)
    phi_d = np.mod(np.arctan2(wd_y, wd_x), 2.0 * np.pi)
    at_pole = at_pole_h | (theta_d < _POLE) | (phi_d >= 2.0 * np.pi)
    return theta_h, theta_d, np.where(at_pole, 0.0, phi_d)


def directions_from_half_diff(
    theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return (wi, wo), each (..., 3), with the half vector at azimuth 0.

    Every triple gives unit vectors; some lie below the horizon (z < 0), where no
    BRDF is defined. Inverse of `half_diff_from_directions` up to a rotation about
    the normal.
    """
    theta_h, theta_d, phi_d = np.broadcast_arrays(
        np.asarray(theta_h, float), np.asarray(theta_d, float), np.asarray(phi_d, float)
    )
    sin_h, cos_h = np.sin(theta_h), np.cos(theta_h)
    sin_d, cos_d = np.sin(theta_d), np.cos(theta_d)
    x, y = sin_d * np.cos(phi_d), sin_d * np.sin(phi_d)
    # wi = R_y(theta_h) wd, and wo mirrors it about wh: wd with x and y negated.
    wi = np.stack([cos_h * x + sin_h * cos_d, y, cos_h * cos_d - sin_h * x], axis=-1)
    wo = np.stack([-cos_h * x + sin_h * cos_d, -y, cos_h * cos_d + sin_h * x], axis=-1)
    return wi, wo


def cos_incident_outgoing(
    theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return (cos theta_i, cos theta_o) without building the vectors."""
    both = np.cos(theta_h) * np.cos(theta_d)
    apart = np.sin(theta_h) * np.sin(theta_d) * np.cos(phi_d)
    return np.asarray(both - apart), np.asarray(both + apart)


def split_by_horizon(wi: FloatArray, wo: FloatArray) -> tuple[BoolArray, BoolArray]:
    """Return (finite, above), each (n,), of direction pairs (n, 3).

    `above`, a part of `finite`, is where a BRDF is defined: both strictly above the horizon.
    Elsewhere it is 0 where the directions are finite, and unknown where they are not.
    """
    if len(wi) != len(wo):
        raise UsageError(f"wi has {len(wi)} rows but wo has {len(wo)}: they must pair up.")
    finite = np.isfinite(np.hstack([wi, wo])).all(axis=1)
    return finite, finite & (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
