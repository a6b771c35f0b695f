"""Directions drawn by what a table reflects, in Mitsuba's own arrays.

A tenth of them by the cosine, which bounds the weight of what the density misses between its
nodes; the others by half vectors, see `half_vectors`. The density of wo follows from that of the
half vector by dividing through 4 wi . wh.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from brdfit.mitsuba.half_vectors import HalfVectorDensity
from brdfit.table import Table
from brdfit.tone import LUMINANCE

__all__ = ["Drawing"]

_BY_COSINE = 0.1
_LEAST = 1e-9
# Products of two small sines must stay above what single precision can hold.
_LEAST_PRODUCT = 1e-20


class Drawing:
    """Draws directions for a table with R, G and B, or with wavelengths."""

    def __init__(self, mi: Any, dr: Any, table: Table) -> None:
        self._mi, self._dr = mi, dr
        found = HalfVectorDensity.of(_grey(table))
        self._density = mi.MarginalContinuous2D1(found.density, [found.theta_i.tolist()])

    def draw(self, wi: Any, sample1: Any, sample2: Any) -> Any:
        """Return wo for numbers in [0, 1); rounding may leave some at the horizon."""
        mi, dr = self._mi, self._dr
        at, _ = self._density.sample(sample2, [_polar(dr, wi)])
        u = at.x * self._u_most(wi)
        theta_h = u * u * (0.5 * dr.pi)
        sin_h, cos_h = dr.sincos(theta_h)
        azimuth = (2.0 * at.y - 1.0) * self._arc(wi, sin_h, cos_h) + dr.atan2(wi.y, wi.x)
        sin_phi, cos_phi = dr.sincos(azimuth)
        wh = mi.Vector3f(sin_h * cos_phi, sin_h * sin_phi, cos_h)
        mirrored = 2.0 * dr.dot(wi, wh) * wh - wi
        even = mi.warp.square_to_cosine_hemisphere(sample2)
        return dr.select(sample1 < _BY_COSINE, even, mirrored)

    def density(self, wi: Any, wo: Any) -> Any:
        """Return the density of wo over solid angle, for directions above the surface."""
        mi, dr = self._mi, self._dr
        wh = dr.normalize(wi + wo)
        theta_h, sin_h = _polar(dr, wh), dr.sqrt(wh.x * wh.x + wh.y * wh.y)
        u, u_most = dr.sqrt(theta_h * (2.0 / dr.pi)), self._u_most(wi)
        arc = self._arc(wi, sin_h, wh.z)
        turn = dr.atan2(wi.x * wh.y - wi.y * wh.x, wi.x * wh.x + wi.y * wh.y)
        y = 0.5 + 0.5 * turn / dr.maximum(arc, _LEAST)
        at = mi.Point2f(dr.clip(u / u_most, 0.0, 1.0), dr.clip(y, 0.0, 1.0))
        # d(omega_h) over dx dy
        area = dr.maximum(2.0 * dr.pi * u * sin_h * u_most * arc, _LEAST)
        by_half = self._density.eval(at, [_polar(dr, wi)]) / area
        by_half /= 4.0 * dr.maximum(dr.dot(wi, wh), _LEAST)
        return _BY_COSINE * wo.z * (1.0 / dr.pi) + (1.0 - _BY_COSINE) * by_half

    def _u_most(self, wi: Any) -> Any:
        dr = self._dr
        return dr.sqrt((0.5 * dr.pi + _polar(dr, wi)) * (1.0 / dr.pi))

    def _arc(self, wi: Any, sin_h: Any, cos_h: Any) -> Any:
        dr = self._dr
        sines = dr.maximum(dr.sqrt(wi.x * wi.x + wi.y * wi.y) * sin_h, _LEAST_PRODUCT)
        bound = wi.z * (0.5 / dr.maximum(cos_h, _LEAST) - cos_h) / sines
        return dr.acos(dr.clip(bound, -1.0, 1.0))


def _polar(dr: Any, w: Any) -> Any:
    # the arc cosine would lose half of the digits near the normal
    return dr.atan2(dr.sqrt(w.x * w.x + w.y * w.y), w.z)


def _grey(table: Table) -> Table:
    """Return the table with the one channel by which directions are drawn."""
    rgb = table.wavelengths is None
    weights = np.asarray(LUMINANCE if rgb else [1.0 / table.n_channels] * table.n_channels)
    return Table(table.values @ weights, grid=table.grid, valid=table.valid)
