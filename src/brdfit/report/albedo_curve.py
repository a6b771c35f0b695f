"""The directional albedo of a table over incidence, as it is told and kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.table import Table

__all__ = ["AlbedoCurve"]

# Every 5 degrees, and the two where extrapolation shows first.
_DEGREES = np.array([*range(0, 90, 5), 87, 89], dtype=np.float64)
# What interpolation and the integral are good for.
_ABOVE_ONE = 1.002


@dataclass(frozen=True, eq=False)
class AlbedoCurve:
    """What a table reflects of a beam; above 1 no surface can be.

    | name      | shape              | unit                           |
    |-----------|--------------------|--------------------------------|
    | `degrees` | (angles,)          | angle of incidence, 0 to 89    |
    | `albedo`  | (angles, channels) | reflected over received power  |
    """

    degrees: FloatArray
    albedo: FloatArray
    channels: tuple[str, ...]

    @classmethod
    def of(cls, table: Table) -> AlbedoCurve:
        """Return that of a table, negative values as they are."""
        found = directional_albedo(table, np.radians(_DEGREES))
        return cls(_DEGREES, found, table.channels)

    @property
    def largest(self) -> float:
        """The largest over incidences and channels."""
        return float(self.albedo.max())

    @property
    def above_one(self) -> bool:
        """Whether more light leaves than arrives at some incidence."""
        return self.largest > _ABOVE_ONE

    def record(self) -> dict[str, Any]:
        """Return everything as JSON-able values."""
        angle, channel = self._worst
        curves = zip(self.channels, np.round(self.albedo, 4).T.tolist(), strict=True)
        return {
            "quantity": "directional albedo: reflected over received power, 1 is a white furnace",
            "sentence": str(self),
            "largest": self.largest,
            "at_degrees": float(self.degrees[angle]),
            "channel": self.channels[channel],
            "theta_i_degrees": self.degrees.tolist(),
            "values": dict(curves),
        }

    def __str__(self) -> str:
        """Return one line for a person."""
        angle, channel = self._worst
        line = (
            f"at most {self.largest:.3f} ({self.channels[channel]}, at "
            f"{self.degrees[angle]:.0f} degrees of incidence)"
        )
        if not self.above_one:
            return line
        over = self.degrees[(self.albedo > _ABOVE_ONE).any(axis=1)]
        span = (
            f"at {over[0]:.0f}" if over.size == 1 else f"between {over[0]:.0f} and {over[-1]:.0f}"
        )
        return f"{line}: more light leaves than arrives {span} degrees"

    @property
    def _worst(self) -> tuple[int, int]:
        angle, channel = np.unravel_index(np.argmax(self.albedo), self.albedo.shape)
        return int(angle), int(channel)
