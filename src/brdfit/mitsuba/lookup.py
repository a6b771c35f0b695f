"""A table in Mitsuba's own arrays, looked up between its nodes.

The value between nodes is the one of `Table.evaluate`: linear between the valid ones around. To
have it from plain interpolation, every cell gets a weight that is interpolated with it and divided
out: 1 for a valid cell, next to nothing for another one, which then holds what its nearest valid
cell does. Only where none of the eight is valid the two differ: `Table.evaluate` answers with the
nearest valid cell alone, the plugin with the mean of those nearest to the eight.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.table import Table

__all__ = ["Lookup"]

_NEXT_TO_NOTHING = 1e-5
_POLE = 1e-6


class Lookup:
    """The values of a table with R, G and B, or with wavelengths, for the variant `mi`."""

    def __init__(self, mi: Any, dr: Any, table: Table) -> None:
        self._mi, self._dr = mi, dr
        nm = table.wavelengths
        order = np.arange(table.n_channels) if nm is None else np.argsort(nm)
        self._nm = [] if nm is None else nm[order].tolist()
        weighted = _weighted(table, order)
        # the nodes of phi_d = pi are those of phi_d = 0
        closed = np.concatenate([weighted, weighted[:, :, :1]], axis=2)
        # without hardware units, which interpolate in steps of 1/256
        self._texture = mi.Texture3f(mi.TensorXf(closed), False, wrap_mode=dr.WrapMode.Clamp)
        self._shape = table.grid.shape

    def evaluate(self, wi: Any, wo: Any, wavelengths: Any) -> Any:
        """Return f_r in the variant's own spectrum, for directions above the surface."""
        *weighted, weight = self._texture.eval(self._position(wi, wo))
        values = [value / weight for value in weighted]
        if self._nm:
            return self._between_bands(values, wavelengths)
        rgb = self._mi.Color3f(*values)
        return self._mi.Spectrum(self._mi.luminance(rgb)) if self._mi.is_monochromatic else rgb

    def _position(self, wi: Any, wo: Any) -> Any:
        """Return where in the texture, [0, 1]^3 as (phi_d, theta_d, theta_h)."""
        theta_h, theta_d, phi_d = self._half_difference(wi, wo)
        n_h, n_d, n_p = self._shape
        pi = self._dr.pi
        return self._mi.Point3f(
            (phi_d * (n_p / pi) + 0.5) / (n_p + 1),
            (theta_d * (n_d * 2.0 / pi) + 0.5) / n_d,
            (self._dr.sqrt(theta_h * (2.0 / pi)) * n_h + 0.5) / n_h,
        )

    def _half_difference(self, wi: Any, wo: Any) -> tuple[Any, Any, Any]:
        """Return (theta_h, theta_d, phi_d in [0, pi]) as `brdfit.geometry` does."""
        dr = self._dr
        both, apart = wi + wo, wi - wo
        wh = dr.normalize(both)
        sin_h = dr.sqrt(wh.x * wh.x + wh.y * wh.y)
        theta_h, theta_d = dr.atan2(sin_h, wh.z), dr.atan2(dr.norm(apart), dr.norm(both))
        at_pole = sin_h < _POLE
        over = 1.0 / dr.select(at_pole, 1.0, sin_h)
        cos_phi, sin_phi = (
            dr.select(at_pole, 1.0, wh.x * over),
            dr.select(at_pole, 0.0, wh.y * over),
        )
        x = wh.z * (cos_phi * wi.x + sin_phi * wi.y) - sin_h * wi.z
        phi_d = dr.atan2(cos_phi * wi.y - sin_phi * wi.x, x)
        # light and viewer may be exchanged
        phi_d = dr.select(phi_d < 0.0, phi_d + dr.pi, phi_d)
        return theta_h, theta_d, dr.select(at_pole | (theta_d < _POLE), 0.0, phi_d)

    def _between_bands(self, values: Sequence[Any], wavelengths: Any) -> Any:
        """Return values linear between the bands, constant beyond the first and the last."""
        mi, dr = self._mi, self._dr
        result = mi.Spectrum(values[0])
        for low, high, a, b in zip(self._nm, self._nm[1:], values, values[1:], strict=False):
            within = dr.clip((wavelengths - low) / (high - low), 0.0, 1.0)
            result = dr.select(wavelengths >= low, a + (b - a) * within, result)
        return result


def _weighted(table: Table, order: IntArray) -> FloatArray:
    """Return (n_theta_h, n_theta_d, n_phi_d, channels + 1) float32: weighted values, weights."""
    values = table.values
    if not table.mask.all():
        flat = values.reshape(-1, table.n_channels)
        values = np.where(table.mask[..., None], values, flat[table.nearest_valid])
    weight = np.where(table.mask, 1.0, _NEXT_TO_NOTHING)[..., None]
    return np.concatenate([values[..., order] * weight, weight], axis=3).astype(np.float32)
