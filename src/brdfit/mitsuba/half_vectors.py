"""Half vectors for a given incidence as points of the unit square, and how densely to draw them.

With u = sqrt(2 theta_h / pi), the warp of the MERL grid, a point (x, y) of the square is

    u = x u_most,             u_most = sqrt((pi/2 + theta_i) / pi)
    phi_h = (2 y - 1) a,      cos(a) = cos_i (1 / (2 cos_h) - cos_h) / (sin_i sin_h)

phi_h counted from the azimuth of wi. Beyond u_most, and beyond the arc a, wi is mirrored below the
surface: the square holds the half vectors that reflect upward, all of them and no other, so that
no direction is drawn in vain and the density adds up to 1.

The density at an incidence is that of the light reflected there,

    f_r cos(theta_o) 4 (wi . wh) d(omega_h),   d(omega_h) = pi u sin(theta_h) u_most 2 a dx dy,

by which a direction carries nearly the same weight wherever it falls. Between incidences it is
interpolated, which the square makes smooth: its edges stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray, safe_arccos
from brdfit.geometry import directions_from_spherical

__all__ = ["HalfVectorDensity"]

_INCIDENCES = 40
_LAST = np.deg2rad(89.5)
_ALONG_X, _ALONG_Y = 128, 48
# Nowhere nothing: what is black between the nodes may be drawn, and a black incidence too.
_FLOOR = 1e-4
_BLACK = 1e-12


@dataclass(frozen=True)
class HalfVectorDensity:
    """Densities over the square, unnormalised, float32."""

    theta_i: FloatArray
    """(incidences,) radians, ascending from 0."""
    density: FloatArray
    """(incidences, along y, along x)."""

    @classmethod
    def of(cls, brdf: Evaluable) -> HalfVectorDensity:
        """Return the densities of a BRDF of one channel."""
        theta_i = np.linspace(0.0, _LAST, _INCIDENCES)
        density = np.stack([_reflected(brdf, angle) for angle in theta_i])
        return cls(theta_i, density.astype(np.float32))


def _reflected(brdf: Evaluable, theta_i: float) -> FloatArray:
    """Return (along y, along x) light that is reflected at `theta_i`, per area of the square."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, _ALONG_X), np.linspace(0.0, 1.0, _ALONG_Y))
    u_most = np.sqrt((np.pi / 2 + theta_i) / np.pi)
    u = x * u_most
    theta_h = u * u * (np.pi / 2)
    arc = _arc(theta_i, theta_h)
    wh = directions_from_spherical(theta_h, (2.0 * y - 1.0) * arc).reshape(-1, 3)
    wi = np.array([np.sin(theta_i), 0.0, np.cos(theta_i)])
    cos_d = wh @ wi
    wo = 2.0 * cos_d[:, None] * wh - wi
    # on the edge itself rounding decides; there is nothing to see there either way
    wo[:, 2] = np.maximum(wo[:, 2], 1e-9)
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    value = brdf.evaluate(np.broadcast_to(wi, wo.shape), wo)[:, 0]
    seen = (np.maximum(value, 0.0) * np.maximum(cos_d, 0.0) * wo[:, 2]).reshape(x.shape)
    measure = u * np.sin(theta_h) * arc
    density = seen * measure
    return np.asarray(density + max(_FLOOR * float(density.max()), _BLACK) * measure)


def _arc(theta_i: float, theta_h: FloatArray) -> FloatArray:
    """Return a, in [0, pi], shaped as `theta_h`."""
    cos_h = np.maximum(np.cos(theta_h), 1e-9)
    sines = np.maximum(np.sin(theta_i) * np.sin(theta_h), 1e-300)
    return safe_arccos(np.cos(theta_i) * (0.5 / cos_h - cos_h) / sines)
