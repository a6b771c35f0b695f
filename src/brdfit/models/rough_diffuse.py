"""A rough diffuse surface that loses no light: Oren-Nayar as Fujii and Portsmouth write it.

    f(wi, wo) = albedo A (1 + r s/t) / pi  +  f_ms

    s = wi . wo - cos_i cos_o      t = max(cos_i, cos_o) where s > 0, else 1
    A = 1 / (1 + (1/2 - 2/(3 pi)) r)

Brighter than a Lambertian toward the light, flatter across. f_ms returns what the first term
loses by inter-reflection: with albedo 1 the directional albedo is 1 at every angle.

References: M. Oren, S. Nayar, "Generalization of Lambert's Reflectance Model", SIGGRAPH 1994;
J. Portsmouth, P. Kutz, S. Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF",
JCGT 14(1), 2025.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns

__all__ = ["RoughDiffuse"]

# Of A, and of the mean albedo over the hemisphere.
_LOSS = 0.5 - 2.0 / (3.0 * np.pi)
_MEAN = 2.0 / 3.0 - 28.0 / (15.0 * np.pi)


@dataclass(frozen=True, eq=False)
class RoughDiffuse:
    """Parameters (columns,)."""

    albedo: npt.ArrayLike
    """Of a facet, [0, 1]."""
    roughness: npt.ArrayLike
    """r, [0, 1]; 0 is a Lambertian."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        albedo, r = np.asarray(self.albedo), np.asarray(self.roughness)
        cos_i, cos_o = angles.cos_i, angles.cos_o
        scale = 1.0 / (1.0 + _LOSS * r)
        s = 2.0 * angles.cos_d**2 - 1.0 - cos_i * cos_o
        leaning = np.where(s > 0.0, s / np.maximum(cos_i, cos_o), s)
        once = albedo * scale * (1.0 + r * leaning)
        # 1 - E(theta) and 1 - mean E at albedo 1: what the first term leaves over
        left_i = 1.0 - scale * (1.0 + r * _hump(cos_i))
        left_o = 1.0 - scale * (1.0 + r * _hump(cos_o))
        left = 1.0 - scale * (1.0 + r * _MEAN)
        again = albedo**2 * (1.0 - left) / (1.0 - albedo * left)
        # at r = 0 nothing is left over, 0 / 0
        often = again * left_i * left_o / np.where(left > 0.0, left, 1.0)
        return np.asarray((once + often) / np.pi)


def _hump(cosine: FloatArray) -> FloatArray:
    # G(theta) / pi of the closed form of the first term's albedo, E = A (1 + r G / pi)
    sine = np.sqrt(1.0 - cosine**2)
    first = sine * (np.arccos(cosine) - sine * cosine)
    second = 2.0 / 3.0 * (sine / cosine * (1.0 - sine**3) - sine)
    return np.asarray((first + second) / np.pi)
