"""A material of several parts: the sum of their BRDFs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.models.angles import PairAngles

__all__ = ["Layered", "Part"]


class Part(Protocol):
    """What every analytic model offers besides `evaluate`."""

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""


@dataclass(frozen=True, eq=False)
class Layered:
    """The sum of parts with the same columns."""

    parts: tuple[Part, ...]

    def __post_init__(self) -> None:
        if not self.parts:
            raise UsageError("Layered: no parts were given; a material has at least one.")

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        value = self.parts[0].at(angles)
        for part in self.parts[1:]:
            value = value + part.at(angles)
        return value
