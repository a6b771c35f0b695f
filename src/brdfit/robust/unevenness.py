"""A variance that is not the same everywhere: ln of its factor is linear in features of a row.

    V_i = V g_i,     ln g_i = x_i beta - m,     m the median of x_i beta over the rows

so that V is the variance of a typical row. beta has a normal prior around 0 and is found by
Newton's steps of the likelihood of the residuals, one whenever residuals are judged anew:

    beta += (X^T R X + lambda I)^-1 (X^T R (q / mean q - 1) - lambda beta)

with q_i the squared residual of a row over the variance it was said to have, times what the
tails make it count for, and R the rows' responsibilities.

Reference: A. C. Harvey, "Estimating Regression Models with Multiplicative Heteroscedasticity",
Econometrica 44(3), 1976 (the likelihood; its information matrix is X^T X / 2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["Unevenness"]

# lambda: rows that a feature needs before it has half a say.
_SHRINKAGE = 10.0
# A row that is further off than this many times its variance says no more.
_MOST = 5.0
# ln g moves by no more than this in a step, for each feature.
_STEP = 1.5


@dataclass(frozen=True, eq=False)
class Unevenness:
    """How much larger the variance is in some places than at a typical row."""

    slopes: FloatArray | None = None
    """beta (p,); None for the same everywhere."""
    middle: float = 0.0
    """m."""

    def factor(self, features: FloatArray) -> FloatArray:
        """Return g (n,), > 0, of rows of `features` (n, p)."""
        if self.slopes is None:
            return np.ones(len(features))
        return np.asarray(np.exp(features @ self.slopes - self.middle))

    def updated(self, features: FloatArray, size: FloatArray, weights: FloatArray) -> Unevenness:
        """Return it after one step, for `size` q (n,) of rows that count for `weights` (n,)."""
        slopes = np.zeros(features.shape[1]) if self.slopes is None else self.slopes
        mean = float(weights @ size) / max(float(weights.sum()), 1e-9)
        excess = weights * (np.minimum(size / max(mean, 1e-300), _MOST) - 1.0)
        information = features.T @ (weights[:, None] * features)
        information[np.diag_indices_from(information)] += _SHRINKAGE
        step = np.linalg.solve(information, features.T @ excess - _SHRINKAGE * slopes)
        slopes = slopes + np.clip(step, -_STEP, _STEP)
        return Unevenness(slopes, float(np.median(features @ slopes)) if len(features) else 0.0)
