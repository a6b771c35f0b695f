"""What a fit of `Posterior` leaves: a function of direction that knows how sure it is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.reconstruct.posterior.calibration import Calibration
from brdfit.reconstruct.posterior.kernel import Angles
from brdfit.reconstruct.posterior.principal import PrincipalBasis
from brdfit.reconstruct.posterior.stages import Winner

__all__ = ["PosteriorModel"]

_CHUNK = 8192
# ln f_r: what is written stays within what a float32 and a renderer can hold.
_LOWEST, _HIGHEST = -30.0, 30.0


@dataclass(frozen=True, eq=False)
class PosteriorModel:
    """ln f_r = [mu | B] w + constant + local residual, and the covariance of its coefficients."""

    basis: PrincipalBasis
    winner: Winner

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        parts: list[FloatArray] = [np.empty((0, self.winner.solution.local.shape[1]))]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            parts.append(self.winner.mean(*self._at(wi[rows], wo[rows])))
        return np.asarray(np.exp(np.clip(np.concatenate(parts), _LOWEST, _HIGHEST)))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (grid.cells.size, c), 1/sr."""
        system, solution = self.winner.system, self.winner.solution
        combination, constant = system.prior.combination(solution.population)
        stored = self.basis.on_grid(grid, progress)
        local = system.kernel.on_grid(grid, system.centres, solution.local)
        local = local.reshape(grid.size, -1)
        combination, constant = combination.astype(np.float32), constant.astype(np.float32)
        result = np.empty((grid.cells.size, local.shape[1]), dtype=np.float32)
        # One theta_h at a time, so that every step finds what the last one left in the cache.
        for cells, rows in stored.slabs():
            part, block = result[cells], stored.rows[rows] @ combination
            block += constant
            np.take(block, stored.expand[cells] - rows.start, axis=0, out=part, mode="clip")
            part += local[grid.cells[cells]]
            np.clip(part, _LOWEST, _HIGHEST, out=part)
            np.exp(part, out=part)
        return result

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return the standard deviation of ln f_r (n, c), the same for every channel.

        Of the BRDF itself: a measurement scatters by the noise of the fit besides. In units of
        `calibration`.
        """
        variance: list[FloatArray] = [np.empty(0)]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            variance.append(self.winner.variance(*self._at(wi[rows], wo[rows])))
        deviation = self.calibration.unit * np.sqrt(np.concatenate(variance))
        channels = self.winner.solution.local.shape[1]
        return np.repeat(deviation[:, None], channels, axis=1)

    @property
    def noise(self) -> float:
        """Standard deviation of ln f_r of a good sample."""
        return self.calibration.unit * self.winner.explanation.belief.width

    @cached_property
    def calibration(self) -> Calibration:
        """What the left-out samples say of the stated deviations."""
        explained = self.winner.explanation
        belief = explained.belief
        return Calibration.of(explained.surprise, belief.responsibility, belief.mixture.freedom)

    def deviations(self, level: float) -> float:
        """Return how many stated deviations hold a share `level` of good measurements."""
        return self.calibration.deviations(level)

    def prior_stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return that of ln f_r before any sample (n,), the brightness known."""
        parts: list[FloatArray] = [np.empty(0)]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            parts.append(self.winner.prior_variance(self.basis.at(wi[rows], wo[rows])))
        return np.asarray(np.sqrt(np.concatenate(parts)))

    def _at(self, wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, Angles]:
        return self.basis.at(wi, wo), half_diff_from_directions(wi, wo)
