"""What a fit of `Posterior` leaves: a function of direction that knows how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.reconstruct.posterior.principal import PrincipalBasis
from brdfit.reconstruct.posterior.residual import LocalResidual
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
        parts = [np.empty((0, self.winner.explanation.coefficients.shape[1]))]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            base, features = self._features(wi[rows], wo[rows])
            parts.append(base[:, None] + features @ self.winner.explanation.coefficients)
        return np.exp(np.clip(np.concatenate(parts), _LOWEST, _HIGHEST))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (grid.cells.size, c), 1/sr."""
        prior, kernel = self.winner.prior, self.winner.kernel
        coefficients = self.winner.explanation.coefficients
        combination, constant = prior.combination(coefficients[: prior.size])
        stored = self.basis.on_grid(grid, progress)
        combination = combination.astype(np.float32)
        blocks = [
            stored.rows[start : start + _CHUNK] @ combination
            for start in range(0, len(stored.rows), _CHUNK)
        ]
        result = (np.concatenate(blocks) + constant.astype(np.float32))[stored.expand]
        local = LocalResidual.of(kernel.scale).on_axes(
            kernel.amplitude * coefficients[prior.size :], grid.theta_h, grid.theta_d, grid.phi_d
        )
        result += local.reshape(-1, result.shape[1])[grid.cells]
        return np.exp(np.clip(result, _LOWEST, _HIGHEST, out=result), out=result)

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return the standard deviation of ln f_r (n, c), the same for every channel.

        Of the BRDF itself: a measurement scatters by the noise of the fit besides.
        """
        variance: list[FloatArray] = [np.empty(0)]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            _, features = self._features(wi[rows], wo[rows])
            variance.append(self.winner.explanation.posterior.variance(features))
        deviation = np.sqrt(np.concatenate(variance))
        channels = self.winner.explanation.coefficients.shape[1]
        return np.repeat(deviation[:, None], channels, axis=1)

    @property
    def noise(self) -> float:
        """Standard deviation of ln f_r of a good sample."""
        return self.winner.explanation.belief.width

    def prior_stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return that of ln f_r before any sample (n,), the brightness known."""
        brightness = self.winner.prior.size - 1
        variance: list[FloatArray] = [np.empty(0)]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            _, features = self._features(wi[rows], wo[rows])
            variance.append((features**2).sum(axis=1) - features[:, brightness] ** 2)
        return np.asarray(np.sqrt(np.maximum(np.concatenate(variance), 0.0)))

    def _features(self, wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, FloatArray]:
        components = self.basis.at(wi, wo)
        return self.winner.features(components, half_diff_from_directions(wi, wo))
