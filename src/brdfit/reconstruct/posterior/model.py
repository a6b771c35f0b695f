"""What a fit of `Posterior` leaves: a function of direction that knows how sure it is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.linalg import thin_product
from brdfit.progress import Progress
from brdfit.reconstruct.posterior.calibration import Calibration, beyond_samples
from brdfit.reconstruct.posterior.detail import Detail
from brdfit.reconstruct.posterior.kernel import Angles
from brdfit.reconstruct.posterior.nodes import residual_on_grid
from brdfit.reconstruct.posterior.places import places
from brdfit.reconstruct.posterior.principal import PrincipalBasis
from brdfit.reconstruct.posterior.refine import Belief
from brdfit.reconstruct.posterior.winner import Winner
from brdfit.reconstruct.slab_cells import HIGHEST, LOWEST, add_rows, put_values
from brdfit.reconstruct.slabs import filled, highest

__all__ = ["PosteriorModel"]

_CHUNK = 8192


@dataclass(frozen=True, eq=False)
class PosteriorModel:
    """ln f_r = [mu | B] w + constant + local residual + detail, and how sure it is."""

    basis: PrincipalBasis
    winner: Winner
    detail: Detail | None = None

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        parts: list[FloatArray] = [np.empty((0, self.winner.solution.local.shape[1]))]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            components, angles = self._at(wi[rows], wo[rows])
            part = self.winner.mean(components, angles)
            parts.append(part if self.detail is None else part + self.detail.at(angles))
        return np.asarray(np.exp(np.clip(np.concatenate(parts), LOWEST, HIGHEST)))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr, float32; 0 below the horizon."""
        return self.seen_dense(grid, progress)[0]

    def seen_dense(self, grid: Grid, progress: Progress) -> tuple[FloatArray, bool]:
        """Return what `dense` does, and whether all of it was seen to be finite."""
        system, solution = self.winner.system, self.winner.solution
        combination, constant = system.prior.combination(solution.population)
        combination, constant = combination.astype(np.float32), constant.astype(np.float32)
        components = self.basis.on_grid(grid, progress)
        local = residual_on_grid(system.kernel, grid, system.centres, solution.local)
        detail = None if self.detail is None else self.detail.on_grid(grid)
        most = highest(grid)

        def put(rings: slice, cells: FloatArray) -> None:
            for i, values in zip(range(rings.start, rings.stop), cells, strict=True):
                logs = local.at(i)
                if detail is not None:
                    logs += detail.at(i)
                logs = logs.reshape(len(logs), -1)
                rows, row_of = components.ring(i)
                add_rows(logs, thin_product(rows, combination), row_of, constant)
                put_values(logs, most[i], values)

        return filled(grid, solution.local.shape[1], put, progress)

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return the standard deviation of ln f_r (n, c), the same for every channel.

        Of the BRDF itself: a measurement scatters by the noise of the fit besides. Where good
        samples are further from one another's predictions than elsewhere, so is the BRDF, and
        beyond the samples it is further off than the process says. In units of `calibration`.
        """
        variance: list[FloatArray] = [np.empty(0)]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            variance.append(self._variance(wi[rows], wo[rows]))
        deviation = self.calibration.unit * np.sqrt(np.concatenate(variance))
        channels = self.winner.solution.local.shape[1]
        return np.repeat(deviation[:, None], channels, axis=1)

    def _unexplained(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return s^2 (g - 1) (n,), at least 0: what is off beyond the noise of a typical place."""
        belief = self.winner.explanation.belief
        excess = belief.unevenness.factor(places(wi, wo)) - 1.0
        return np.asarray(belief.width**2 * np.maximum(excess, 0.0))

    @property
    def noise(self) -> float:
        """Standard deviation of ln f_r of a good sample."""
        return self.calibration.unit * self.belief.width

    @property
    def belief(self) -> Belief:
        """Of the samples that decided last: who is believed, and at which noise."""
        return self.winner.explanation.belief if self.detail is None else self.detail.belief

    @cached_property
    def calibration(self) -> Calibration:
        """What the left-out samples say of the stated deviations."""
        return self._of_smooth if self.detail is None else self.detail.calibration

    @cached_property
    def _of_smooth(self) -> Calibration:
        explained = self.winner.explanation
        belief = explained.belief
        return Calibration.of(explained.surprise, belief.responsibility, belief.mixture.freedom)

    @cached_property
    def _typical_variance(self) -> float:
        """That of ln f_r at a sample, known by the others."""
        return float(np.median(self.winner.explanation.left_out.variance))

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

    def _variance(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return that of ln f_r (n,), in units of `calibration`."""
        components, angles = self._at(wi, wo)
        of_process = self.winner.variance(components, angles) + self._unexplained(wi, wo)
        found = beyond_samples(of_process, self._typical_variance)
        if self.detail is None:
            return found
        return self.detail.variance(angles, found * self._of_smooth.unit**2)

    def _at(self, wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, Angles]:
        return self.basis.at(wi, wo), half_diff_from_directions(wi, wo)
