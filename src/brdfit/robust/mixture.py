"""Two components for every row: a measurement with its own noise, or something else.

A row i has residuals e_ic = y_ic - prediction over its known entries c. With probability
1 - pi it is an *inlier*, e normal of variance V_i, or of Student's t with nu degrees of freedom
and that scale: predictions of a BRDF are far off more often than a normal allows, where it
changes faster than the samples tell. With probability pi it is an *outlier*, of one of two
kinds. Either its value is the right one times some factor (a gain, an exposure, a shadow): a
normal around the prediction that is much broader than noise. Or it knows of no prediction: a
density O over the values themselves (`background`). Both are what the outliers found so far
make of them, and so is the share q of the first kind.

    E_i    = mean over c of  e_ic^2
    ln N_i = -1/2 (E_i / V_i + ln 2 pi V_i)      or     ln t_nu(sqrt(E_i); V_i)
    ln F_i = -1/2 (E_i / V + ln 2 pi V),  V = V_i + spread^2
    ln O_i = mean over c of  ln O(y_ic)

    r_i = (1 - pi) N_i / ((1 - pi) N_i + pi (q F_i + (1 - q) O_i))     responsibility, or weight

Means over the entries, not sums: entries of a row are wrong together, and thirty bands of
one direction are not thirty witnesses. Repeating a column changes nothing.

Student's t is a normal of unknown variance: u_i = (nu + 1) / (nu + E_i / V_i), the expected
V_i over that variance, is what an inlier counts for (1 for a normal).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.robust.background import Background, mean_known

__all__ = ["Factors", "Mixture", "Verdict"]

_LOG_TWO_PI = float(np.log(2.0 * np.pi))
# Pseudo-counts of the share of outliers, Beta(a, b): 20 samples must not settle on 0 or 1.
_PRIOR_WRONG, _PRIOR_RIGHT = 0.5, 4.5
# Imagined outliers of each kind, and the narrowest and widest spread of a factor, ln.
_IMAGINED_FACTORS, _NARROWEST, _WIDEST = 2.0, 0.7, 2.5


@dataclass(frozen=True)
class Factors:
    """Outliers that are the right value times a factor: their share q, and how wide ln is."""

    share: float = 0.5
    spread: float = 1.5

    @classmethod
    def of(cls, wrong: FloatArray, factor: FloatArray, square: FloatArray) -> Factors:
        """Fit it to rows that are `wrong` (n,), `factor` (n,) of that by a factor.

        `square` (n,) are mean squared residuals. A few imagined outliers stay as `Factors()`.
        """
        total, before = float(factor.sum()), cls()
        share = (total + before.share * _IMAGINED_FACTORS) / (
            float(wrong.sum()) + _IMAGINED_FACTORS
        )
        squares = float((factor * square).sum()) + _IMAGINED_FACTORS * before.spread**2
        spread = float(np.sqrt(squares / (total + _IMAGINED_FACTORS)))
        return cls(share, float(np.clip(spread, _NARROWEST, _WIDEST)))


@dataclass(frozen=True, eq=False)
class Verdict:
    """What the mixture makes of residuals."""

    responsibility: FloatArray
    """r (n,) in [0, 1]; 0 where nothing is known."""
    log_likelihood: FloatArray
    """ln of the density of a row, both components together (n,); 0 where nothing is known."""
    factor: FloatArray
    """(n,) in [0, 1]: how likely a row is wrong by a factor; at most 1 - responsibility."""
    square: FloatArray
    """E: mean of e^2 over the known entries (n,)."""
    credit: FloatArray
    """u (n,), > 0: what a row counts for, if it is an inlier."""


@dataclass(frozen=True)
class Mixture:
    """The share of outliers pi, and the background they come from."""

    share: float
    background: Background
    factors: Factors = Factors()
    freedom: float = np.inf
    """nu: degrees of freedom of an inlier; infinite for a normal."""

    def judge(
        self, y: FloatArray, mean: FloatArray, variance: FloatArray, known: BoolArray
    ) -> Verdict:
        """Judge y (n, c) against predictions `mean` (n, c) of variance (n,), noise included."""
        square = mean_known((y - mean) ** 2, known)
        q = self.factors.share
        right = np.log1p(-self.share) + self.log_inlier(square, variance)
        factor = np.log(self.share * q) + _log_normal(square, variance + self.factors.spread**2)
        elsewhere = self.background.log_density(y, known) + np.log(self.share * (1.0 - q))
        total = np.logaddexp(right, np.logaddexp(factor, elsewhere))
        any_known = known.any(axis=1)
        return Verdict(
            np.where(any_known, np.exp(right - total), 0.0),
            np.where(any_known, total, 0.0),
            np.where(any_known, np.exp(factor - total), 0.0),
            square,
            self.credit(square, variance),
        )

    def log_inlier(self, square: FloatArray, variance: FloatArray) -> FloatArray:
        """Return ln N_i (n,) of mean squared residuals at variance (n,), noise included."""
        nu = self.freedom
        if np.isinf(nu):
            return _log_normal(square, variance)
        constant = math.lgamma((nu + 1.0) / 2.0) - math.lgamma(nu / 2.0)
        tail = 0.5 * (nu + 1.0) * np.log1p(square / (nu * variance))
        return np.asarray(constant - 0.5 * np.log(nu * np.pi * variance) - tail)

    def credit(self, square: FloatArray, variance: FloatArray) -> FloatArray:
        """Return u (n,) of mean squared residuals at variance (n,), noise included."""
        nu = self.freedom
        if np.isinf(nu):
            return np.ones(len(square))
        return np.asarray((nu + 1.0) / (nu + square / variance))

    def updated(self, y: FloatArray, verdict: Verdict, known: BoolArray) -> Mixture:
        """Return the mixture that fits the responsibilities (n,); its shares within (0, 1)."""
        any_known = known.any(axis=1)
        wrong = np.where(any_known, 1.0 - verdict.responsibility, 0.0)
        rows = float(any_known.sum())
        share = (float(wrong.sum()) + _PRIOR_WRONG) / (rows + _PRIOR_WRONG + _PRIOR_RIGHT)
        elsewhere = np.maximum(wrong - verdict.factor, 0.0)
        return Mixture(
            share,
            Background.of(y, known, elsewhere),
            Factors.of(wrong, verdict.factor, verdict.square),
            self.freedom,
        )


def _log_normal(square: FloatArray, variance: FloatArray) -> FloatArray:
    """Return the mean over entries of ln N(e; 0, V) (n,) from the mean of e^2 (n,)."""
    return np.asarray(-0.5 * (square / variance + np.log(variance) + _LOG_TWO_PI))
