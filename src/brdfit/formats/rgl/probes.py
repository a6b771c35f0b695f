"""How far a measurement is from the BRDF that it was made of, at fixed directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable, directional_albedo
from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_half_diff, directions_from_spherical

__all__ = ["Probes"]

_PAIRS = 4000
_LOWEST_COSINE = np.cos(np.deg2rad(80.0))
_INCIDENCES = np.deg2rad([14.0, 37.0, 53.0, 63.0, 70.0, 75.0, 79.0])
_SEED = 20180611
_RULE = {"rings": 64, "spokes": 8}


@dataclass(frozen=True)
class Probes:
    """Pairs of directions with the values there, and incidences with the albedo there."""

    wi: FloatArray
    """(n, 3), no farther than 80 degrees from the normal, as `wo`."""
    wo: FloatArray
    value: FloatArray
    """(n, channels) f_r."""
    albedo: FloatArray
    """(7, channels) directional albedo."""

    @classmethod
    def of(cls, brdf: Evaluable) -> Probes:
        """Return probes of `brdf`, half of them spread evenly, half as the MERL grid's nodes."""
        rng = np.random.default_rng(_SEED)
        half = _PAIRS // 2
        cosine = rng.uniform(_LOWEST_COSINE, 1.0, (2, half))
        even = directions_from_spherical(np.arccos(cosine), rng.uniform(-np.pi, np.pi, (2, half)))
        u, v, w = rng.uniform(0.0, 1.0, (3, 8 * half))
        near = directions_from_half_diff(u * u * np.pi / 2, v * np.pi / 2, w * 2.0 * np.pi)
        high = np.minimum(near[0][:, 2], near[1][:, 2]) > _LOWEST_COSINE
        chosen = np.flatnonzero(high)[:half]
        wi, wo = (np.concatenate([a, b[chosen]]) for a, b in zip(even, near, strict=True))
        return cls(wi, wo, brdf.evaluate(wi, wo), directional_albedo(brdf, _INCIDENCES, **_RULE))

    def differences(self, brdf: Evaluable) -> tuple[float, float]:
        """Return the mean |delta ln f| where both are above zero, and the largest of albedo.

        The albedo's is relative to that of the brightest channel: one that linear sRGB makes
        negative here and positive there adds up to next to nothing.
        """
        value = brdf.evaluate(self.wi, self.wo)
        both = (value > 0.0) & (self.value > 0.0)
        ratio = np.log(value[both] / self.value[both])
        albedo = directional_albedo(brdf, _INCIDENCES, **_RULE)
        brightest = np.abs(self.albedo).max(axis=1, keepdims=True)
        off = np.abs(albedo - self.albedo) / np.where(brightest > 0.0, brightest, 1.0)
        return float(np.abs(ratio).mean()) if both.any() else 0.0, float(off.max())
