"""The directional albedo of a BRDF: what it reflects of a beam, or of an even surround.

    a(theta_i) = integral f_r(wi, wo) cos(theta_o) d omega_o
               = integral f_r(wi, wo) cos(theta_o) 4 cos(theta_d) d omega_h

The integral is taken over half vectors, since that is where BRDFs are narrow. theta_h =
(pi/2) u^2, the warp of the MERL grid, so that rings are dense around the mirror direction;
on each ring phi_h runs over the arc for which wo is above the horizon, whose ends follow from

    cos(theta_o) = 2 (wi . wh) cos(theta_h) - cos(theta_i).

For a reciprocal BRDF the same figure is what a viewer at theta_i sees of a white furnace.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError

__all__ = ["Evaluable", "albedo_rule", "checked_incidence", "directional_albedo"]

RINGS = 120
SPOKES = 16


class Evaluable(Protocol):
    """Anything that answers for pairs of directions: a table, a model, a reconstruction."""

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels), 1/sr, at direction pairs (n, 3)."""


def directional_albedo(
    brdf: Evaluable, theta_i: npt.ArrayLike, *, rings: int = RINGS, spokes: int = SPOKES
) -> FloatArray:
    """Return the directional albedo (n, channels) of `brdf` at `theta_i` (n,), radians.

    0 for black, 1 for a surface that reflects all it receives, above 1 for one that cannot
    exist. Raises `UsageError` for an angle outside [0, pi/2). With the default rule a white
    Lambertian comes out as 1 to 1e-5, lobes of half a degree and wider to 1 %.
    """
    return np.stack(
        [
            weight @ brdf.evaluate(np.broadcast_to(wi, wo.shape), wo)
            for wi, wo, weight in (
                albedo_rule(angle, rings, spokes) for angle in checked_incidence(theta_i)
            )
        ]
    )


def albedo_rule(
    theta_i: float, rings: int = RINGS, spokes: int = SPOKES
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (wi (3,), wo (n, 3), weight (n,)): the albedo is the sum of weight times f_r.

    The weights hold the solid angle and cos(theta_o). Gauss-Legendre over u and over the
    arc of phi_h on either side of the plane of incidence, so that tables that are not the
    same on both sides are seen whole.
    """
    cos_i, sin_i = np.cos(theta_i), np.sin(theta_i)
    x, share = np.polynomial.legendre.leggauss(rings)
    # beyond this half angle no wo is above the horizon, at any phi_h
    u_most = np.sqrt((np.pi / 2 + theta_i) / np.pi)
    u, du = (x + 1.0) / 2.0 * u_most, share / 2.0 * u_most
    theta_h = u * u * (np.pi / 2)
    sin_h, cos_h = np.sin(theta_h), np.cos(theta_h)
    # cos(theta_o) > 0  <=>  sin_i sin_h cos(phi_h) > cos_i (1 / (2 cos_h) - cos_h)
    bound = cos_i * (0.5 / cos_h - cos_h) / np.maximum(sin_i * sin_h, 1e-300)
    phi_most = np.arccos(np.clip(bound, -1.0, 1.0))
    y, dy = np.polynomial.legendre.leggauss(spokes)
    phi = phi_most[:, None] * (y + 1.0) / 2.0
    d_phi = phi_most[:, None] * dy / 2.0
    phi, d_phi = np.hstack([phi, -phi]), np.hstack([d_phi, d_phi])

    sin_h, cos_h = sin_h[:, None], cos_h[:, None]
    wh = np.stack(
        [sin_h * np.cos(phi), sin_h * np.sin(phi), np.broadcast_to(cos_h, phi.shape)], axis=-1
    )
    wi = np.array([sin_i, 0.0, cos_i])
    cos_d = wh @ wi
    wo = 2.0 * cos_d[..., None] * wh - wi
    # d(theta_h) = pi u du
    ring = (np.pi * u * du)[:, None] * sin_h
    weight = 4.0 * cos_d * ring * d_phi * wo[..., 2]
    above = (weight > 0.0) & (wo[..., 2] > 0.0)
    return wi, wo[above], weight[above]


def checked_incidence(theta_i: npt.ArrayLike) -> FloatArray:
    """Return `theta_i` as (n,) float64; `UsageError` for what is no angle of incidence."""
    angles = np.atleast_1d(np.asarray(theta_i, dtype=np.float64))
    if angles.ndim != 1 or not ((angles >= 0.0) & (angles < np.pi / 2)).all():
        raise UsageError(
            f"theta_i: found {np.array2string(angles, threshold=4)} but angles of incidence are in "
            f"radians, from 0 (the normal) to below pi/2."
        )
    return angles
