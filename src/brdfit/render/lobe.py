"""Half vectors drawn where a BRDF is bright, whatever the BRDF.

The density of theta_h is the mean of f_r over theta_d and phi_d times cos(theta_h), a tenth of
it even, in steps of sqrt(theta_h); phi_h is even. Mirroring wo at the half vector gives wi, with
the density p(wh) / (4 wo . wh).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray, dot, frozen, normalize
from brdfit.geometry import directions_from_half_diff

__all__ = ["Lobe"]

_STEPS = 180
_THETA_D = (8.0, 30.0, 50.0, 68.0)
_PHI_D = (45.0, 90.0, 135.0)
_EVEN = 0.1


@dataclass(frozen=True, eq=False)
class Lobe:
    """The density of half vectors, in steps of u = sqrt(theta_h / (pi / 2))."""

    share: FloatArray
    """(steps,) probability of each, summing to 1."""

    @classmethod
    def of(cls, brdf: Evaluable) -> Lobe:
        """Return the lobe of `brdf`."""
        u = (np.arange(_STEPS) + 0.5) / _STEPS
        theta_h = u * u * (np.pi / 2)
        grid = np.meshgrid(theta_h, np.deg2rad(_THETA_D), np.deg2rad(_PHI_D), indexing="ij")
        wi, wo = directions_from_half_diff(*(axis.ravel() for axis in grid))
        above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
        value = np.zeros(len(wi))
        value[above] = np.nan_to_num(brdf.evaluate(wi[above], wo[above])).clip(0.0).mean(axis=1)
        count = np.maximum(above.reshape(_STEPS, -1).sum(axis=1), 1)
        height = value.reshape(_STEPS, -1).sum(axis=1) / count * np.cos(theta_h)
        # d(omega_h) = sin(theta_h) pi u du d(phi)
        measure = np.sin(theta_h) * u
        share = height * measure
        even = np.cos(theta_h) * measure
        share = (1.0 - _EVEN) * share / max(share.sum(), 1e-300) + _EVEN * even / even.sum()
        return cls(frozen(share / share.sum()))

    def draw(self, wo: FloatArray, u: FloatArray) -> FloatArray:
        """Return wi (n, 3), some below the horizon, for `wo` (n, 3) and points `u` (n, 2)."""
        ends = np.concatenate([[0.0], np.cumsum(self.share)])
        step = np.clip(np.searchsorted(ends, u[:, 0], side="right") - 1, 0, _STEPS - 1)
        within = np.clip((u[:, 0] - ends[step]) / self.share[step], 0.0, 1.0)
        theta = ((step + within) / _STEPS) ** 2 * (np.pi / 2)
        phi = 2.0 * np.pi * u[:, 1]
        sine = np.sin(theta)
        wh = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)], axis=1)
        return np.asarray(2.0 * dot(wo, wh)[:, None] * wh - wo)

    def density(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return how often `draw` gives `wi` for `wo`, per steradian, (n,)."""
        wh = normalize(wi + wo)
        theta = np.arccos(np.clip(wh[:, 2], 0.0, 1.0))
        u = np.sqrt(theta / (np.pi / 2))
        step = np.minimum((u * _STEPS).astype(np.int64), _STEPS - 1)
        # p(theta) d(theta) = share * steps du,  d(theta) = pi u du
        per_theta = self.share[step] * _STEPS / (np.pi * np.maximum(u, 1e-9))
        per_wh = per_theta / (2.0 * np.pi * np.maximum(np.sin(theta), 1e-12))
        return np.asarray(per_wh / (4.0 * np.maximum(dot(wo, wh), 1e-9)))
