"""How far good samples really are from what the others say of them, in stated deviations.

A Gaussian process states sqrt(var_i + V_i) for the distance of row i from the prediction of
all other rows. Where a material changes faster than its samples tell, it is further off; where
it is smooth, nearer. What was left out tells both:

    z_ic = |e_ic| / sqrt(var_i + V_i),  of weight r_i, shared by the known entries c

z(p) is the p-quantile of these, beside `_IMAGINED` rows that are of Student's t as assumed.
Deviations and noise are stated in units of z(0.683), so that one of them holds 68 % of good
samples; the share p lies within z(p) / z(0.683) of them.

That is how far off the process is between samples. Further from them than they are from one
another it is further off than it says, by more the less it knows: what a kernel and a population
take for granted shows only there. `beyond_samples` says by how much.

Reference: R. F. Barber, E. J. Candes, A. Ramdas, R. J. Tibshirani, "Predictive inference with
the jackknife+", Annals of Statistics 49(1), 2021 (quantiles of left-out residuals).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["ONE_SIGMA", "Calibration", "beyond_samples"]

ONE_SIGMA = 0.6827
"""Share of a normal distribution within one standard deviation."""
_IMAGINED = 5.0
_POINTS = 40
# Variance over that of a typical left-out row from which on more is stated, how the variance
# grows with it, and how large the factor gets. Chosen on whole incidence angles that were left
# out of real files, and on samples that were left out at random.
_KNEE, _GROWTH, _MOST = 3.0, 0.8, 4.0


def beyond_samples(variance: FloatArray, typical: float) -> FloatArray:
    """Return the variance (n,) to state, from that of the process and that of left-out rows.

    It is the same up to three times `typical`, and at most four times as large.
    """
    further = variance / (_KNEE * max(typical, 1e-300))
    return np.asarray(variance * np.clip(further**_GROWTH, 1.0, _MOST))


@dataclass(frozen=True, eq=False)
class Calibration:
    """Sorted z of good samples, and how likely one is at most as large."""

    distances: FloatArray
    shares: FloatArray

    @classmethod
    def of(cls, square: FloatArray, responsibility: FloatArray, freedom: float) -> Calibration:
        """Return that of rows with `square` z^2 (n, c), NaN unknown, and `responsibility` (n,)."""
        from scipy.special import stdtrit

        imagined = stdtrit(freedom, 0.5 + 0.5 * (np.arange(_POINTS) + 0.5) / _POINTS)
        known = np.isfinite(square)
        of_entry = (responsibility / np.maximum(known.sum(axis=1), 1))[:, None] * known
        distances = np.concatenate([np.sqrt(square[known]), imagined])
        weights = np.concatenate([of_entry[known], np.full(_POINTS, _IMAGINED / _POINTS)])
        order = np.argsort(distances, kind="stable")
        total = np.cumsum(weights[order])
        # one more row than there are: the one that is asked about
        return cls(distances[order], (total - 0.5 * weights[order]) / (total[-1] + 1.0))

    @property
    def unit(self) -> float:
        """z(0.683)."""
        return self._quantile(ONE_SIGMA)

    def deviations(self, level: float) -> float:
        """Return how many stated deviations, to either side, hold a share `level` in (0, 1)."""
        return self._quantile(level) / self.unit

    def _quantile(self, level: float) -> float:
        return float(np.interp(level, self.shares, self.distances))
