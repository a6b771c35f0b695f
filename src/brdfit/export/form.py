"""What an optimiser may vary: named parameters with their range, and the forms of a material.

A target has several forms, the plainer first: a glTF material may be a dielectric, a metal, or
either under a clear coat. Each form frees some parameters and fixes the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.models import Ggx, PairAngles

__all__ = ["AnalyticMaterial", "Form", "Parameter", "Values", "colour"]

Values = Mapping[str, FloatArray]
"""Parameter name -> values (size,)."""


class AnalyticMaterial(Protocol):
    """A material that a tool describes by a few parameters; R, G, B."""

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, 3), 1/sr, as if every direction were above the horizon."""

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, 3) in 1/sr at (n, 3); 0 below the horizon."""

    def parameters(self) -> dict[str, Any]:
        """Return the parameters by the names that the tool uses, as JSON-able values."""


@dataclass(frozen=True)
class Parameter:
    """A parameter that is varied.

    The optimiser sees its square root where `root` is set: colours and reflectances, of which
    small values matter as much as large ones.
    """

    name: str
    size: int = 1
    low: float = 0.0
    high: float = 1.0
    root: bool = False

    def encode(self, value: FloatArray) -> FloatArray:
        """Return what the optimiser starts from, strictly inside the bounds."""
        margin = 1e-4 * (self.high - self.low)
        inside = np.clip(np.broadcast_to(value, (self.size,)), self.low + margin, self.high)
        return self._root(np.minimum(inside, self.high - margin))

    def decode(self, u: FloatArray) -> FloatArray:
        """Return the value (size,) of what the optimiser found."""
        return u * u if self.root else u

    @property
    def bounds(self) -> tuple[float, float]:
        """Range of what the optimiser sees."""
        low, high = self._root(np.array([self.low, self.high]))
        return float(low), float(high)

    def _root(self, value: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(value)) if self.root else np.asarray(value, dtype=np.float64)


@dataclass(frozen=True)
class Form:
    """One form of a target's material."""

    name: str
    free: tuple[Parameter, ...]
    make: Callable[[Values], AnalyticMaterial]
    """Values of the free parameters -> the material."""
    starts: Callable[[Ggx], Sequence[Values]]
    """Where to begin, from a GGX lobe over a diffuse base that was fitted first."""

    def encode(self, values: Values) -> FloatArray:
        """Return the vector of the optimiser."""
        return np.concatenate([p.encode(np.asarray(values[p.name])) for p in self.free])

    def decode(self, u: FloatArray) -> dict[str, FloatArray]:
        """Return values by name of the optimiser's vector."""
        ends = np.cumsum([p.size for p in self.free])
        parts = np.split(u, ends[:-1])
        return {p.name: p.decode(part) for p, part in zip(self.free, parts, strict=True)}

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """(low, high) of the optimiser's vector."""
        both = np.array([p.bounds for p in self.free for _ in range(p.size)])
        return both[:, 0], both[:, 1]


def colour(value: FloatArray) -> tuple[float, float, float]:
    """Return (r, g, b) of an array (3,) or of one value for all three."""
    r, g, b = (float(v) for v in np.broadcast_to(value, (3,)))
    return r, g, b
