"""What a fit of `Compact` leaves: a few coefficients for each channel, and how sure they are."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.linalg import CoefficientPosterior
from brdfit.progress import Progress
from brdfit.reconstruct.compact.basis import LeadingBasis
from brdfit.reconstruct.slab_cells import HIGHEST, LOWEST
from brdfit.reconstruct.slabs import filled

__all__ = ["CompactModel"]


@dataclass(frozen=True, eq=False)
class CompactModel:
    """ln f_r = mean + phi z; `posterior` is known to a fit, not to a store of many."""

    basis: LeadingBasis
    coefficients: FloatArray = field(repr=False)
    """(1 + k, channels)"""
    posterior: CoefficientPosterior | None = field(default=None, repr=False)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        log = self.basis.log_value(self.coefficients, wi, wo)
        return np.exp(np.clip(log, LOWEST, HIGHEST))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr, float32; 0 below the horizon."""
        return self.seen_dense(grid, progress)[0]

    def seen_dense(self, grid: Grid, progress: Progress) -> tuple[FloatArray, bool]:
        """Return what `dense` does, and whether all of it was seen to be finite."""
        put = self.basis.on_grid(self.coefficients, grid)
        return filled(grid, self.coefficients.shape[1], put, progress)

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        """Return the standard deviation of ln f_r (n, c), the same for every channel.

        Of the BRDF itself: a measurement scatters by the noise of the fit besides.
        """
        if self.posterior is None:
            return None
        deviation = np.sqrt(self.posterior.variance(self.basis.at(wi, wo)[1]))
        return np.repeat(deviation[:, None], self.coefficients.shape[1], axis=1)
