"""Where a result comes from: measured, interpolated between measurements, or supplied.

Two questions are asked of a direction. How far is the nearest sample that is believed? And,
where the method states how sure it is, did the samples make it so? With sigma the stated
standard deviation of ln f_r there, sigma_0 that of the prior (how far materials differ there,
once their brightness is known) and s the noise of a good sample, one measurement at that
direction would leave sigma_1 = 1 / sqrt(1 / sigma_0^2 + 1 / s^2).

    measured       a sample within 5 degrees,    and sigma <= max(2 sigma_1, sigma_0 / 4)
    interpolated   a sample within 15 degrees,   and sigma <= max(2 sigma_1, sigma_0 / 2)
    supplied       anything else: the population, or the method, speaks

So a sample beside a lobe that is narrower than the distance does not make the lobe measured,
nor does one that is taken for an outlier. Far from every sample a result is supplied even if
the method is sure of it: sigma says how sure, the class says from where.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.geometry import half_diff_from_directions, split_by_horizon
from brdfit.grid import Grid
from brdfit.reconstruct.reach import FAR, NEAR, Reach

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Reconstruction

__all__ = ["KnowsItsPrior", "Silent", "StatesDoubt", "Trust", "TrustMap"]

_CHUNK = 2_000
# Times the deviation that one measurement at the direction would leave.
_AS_GOOD_AS_ONE = 2.0
# Share of the prior's deviation that may be left.
_MEASURED, _INTERPOLATED = 0.25, 0.5


class Trust(IntEnum):
    """Where a value comes from."""

    NOTHING = 0
    """There is no BRDF: below the horizon."""
    MEASURED = 1
    INTERPOLATED = 2
    SUPPLIED = 3
    """By the population, or by the method's own extrapolation."""


class StatesDoubt(Protocol):
    """A model that may state how sure it is, or what was kept of one."""

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        """Return the standard deviation of ln f_r (n, channels), or None if unknown."""


class Silent:
    """A model that states nothing: distance decides."""

    def stddev(self, wi: FloatArray, wo: FloatArray) -> None:
        """Return None."""


@runtime_checkable
class KnowsItsPrior(Protocol):
    """A model that tells what it would have said without samples."""

    @property
    def noise(self) -> float:
        """Standard deviation of ln f_r of a good sample."""

    def prior_stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return that of ln f_r before any sample, the brightness known, (n,)."""


@dataclass(frozen=True, eq=False)
class TrustMap:
    """The class of every direction, for one result."""

    reach: Reach
    model: StatesDoubt

    @classmethod
    def of(cls, result: Reconstruction) -> TrustMap:
        """Return the map of a result; samples that it names as outliers support nothing."""
        return cls(Reach(result.samples, ~result.outliers), result.model)

    @property
    def judges(self) -> bool:
        """Whether the method tells what the samples made of its prior; else distance decides."""
        return isinstance(self.model, KnowsItsPrior)

    @property
    def definition(self) -> str:
        """What the classes mean, in words."""
        measured, interpolated = self.criteria
        rest = (
            "all else is supplied by the population"
            if self.judges
            else "beyond that the method supplies the value"
        )
        return f"measured: {measured}; interpolated: {interpolated}; {rest}."

    @property
    def criteria(self) -> tuple[str, str]:
        """What makes a direction measured, and what interpolated, in words."""
        near, far = f"within {NEAR:g} degrees", f"within {FAR:g} degrees"
        if not self.judges:
            return f"a believed sample {near}", far
        return (
            f"a believed sample {near}, and the uncertainty there at most a quarter of what it was "
            f"before any sample, or about what one measurement there would leave",
            f"{far} and at most a half",
        )

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> IntArray:
        """Return the `Trust` of direction pairs (n, 3) as integers (n,)."""
        _, above = split_by_horizon(wi, wo)
        found = np.full(len(above), int(Trust.NOTHING))
        for rows in np.array_split(np.flatnonzero(above), max(1, int(above.sum()) // _CHUNK)):
            deviation = self.model.stddev(wi[rows], wo[rows]) if self.judges else None
            found[rows] = self.classes(wi[rows], wo[rows], deviation)
        return found

    def on_grid(self, grid: Grid) -> IntArray:
        """Return the `Trust` of the nodes of a grid, shaped as the grid, int8."""
        found = np.zeros(grid.size, dtype=np.int8)
        found[grid.cells] = self.evaluate(*grid.directions(grid.cells))
        return found.reshape(grid.shape)

    def classes(self, wi: FloatArray, wo: FloatArray, deviation: FloatArray | None) -> IntArray:
        """Return the classes above the horizon, (n,), where `stddev` (n, c) is known already."""
        degrees = self.reach.degrees(*half_diff_from_directions(wi, wo))
        measured, interpolated = degrees <= NEAR, degrees <= FAR
        if isinstance(self.model, KnowsItsPrior) and deviation is not None:
            stated, prior = deviation.mean(axis=1), self.model.prior_stddev(wi, wo)
            one = 1.0 / np.hypot(1.0 / np.maximum(prior, 1e-9), 1.0 / max(self.model.noise, 1e-9))
            one *= _AS_GOOD_AS_ONE
            measured &= stated <= np.maximum(one, _MEASURED * prior)
            interpolated &= stated <= np.maximum(one, _INTERPOLATED * prior)
        return np.where(
            measured,
            int(Trust.MEASURED),
            np.where(interpolated, int(Trust.INTERPOLATED), int(Trust.SUPPLIED)),
        )
