"""The ideal diffuse BRDF: f = albedo / pi, whatever the directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns

__all__ = ["Lambert"]


@dataclass(frozen=True, eq=False)
class Lambert:
    """One albedo per channel."""

    albedo: npt.ArrayLike = 0.5
    """Reflected over received power, (channels,), [0, 1]."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, channels), as if every direction were above the horizon."""
        albedo = np.asarray(self.albedo)
        return np.broadcast_to(albedo / np.pi, (len(angles.cos_i), albedo.size))
