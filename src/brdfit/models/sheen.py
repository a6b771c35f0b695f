"""The sheen of cloth and dust: facets that stand up, bright at grazing angles.

    f(wi, wo) = tint D / (4 (cos_i + cos_o - cos_i cos_o))

    D = (2 + 1/a) sin(theta_h)^(1/a) / (2 pi)

References: A. Conty Estevez, C. Kulla, "Production Friendly Microfacet Sheen BRDF", SIGGRAPH
2017 courses (the "Charlie" distribution); D. Neubelt, M. Pettineo, "Crafting a Next-Gen
Material Pipeline for The Order: 1886", SIGGRAPH 2013 courses (the denominator, which is finite
at the horizon; the shadowing that Estevez and Kulla fitted is left out).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns

__all__ = ["Sheen"]


@dataclass(frozen=True, eq=False)
class Sheen:
    """Parameters (columns,). Nothing at theta_h = 0: give it a base."""

    tint: npt.ArrayLike
    """Strength, [0, 1]."""
    alpha: npt.ArrayLike
    """Roughness, (0, 1]; small values shine near grazing only."""

    def __post_init__(self) -> None:
        freeze_columns(self)
        if np.any(np.asarray(self.alpha) <= 0.0):
            raise UsageError(f"Sheen: alpha is {np.min(self.alpha):g} but must be above 0.")

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        power = 1.0 / np.asarray(self.alpha)
        sin2_h = angles.tan2_h / (1.0 + angles.tan2_h)
        value = sin2_h ** (0.5 * power)
        value *= np.asarray(self.tint) * (2.0 + power) / (2.0 * np.pi)
        value /= 4.0 * (angles.cos_i + angles.cos_o - angles.cos_i * angles.cos_o)
        return np.asarray(value)
