"""Least squares from normal equations: ridge, and non-negative by Lawson and Hanson.

Minimise (X a - y)^T W (X a - y) given only gram = X^T W X and moment = X^T W y. Forming
them touches the n rows once; everything after is k x k, so that many problems that share
rows (leave-one-out, colour channels) share the work.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize

from brdfit.arrays import FloatArray

__all__ = ["NormalEquations", "RidgeFit", "nonnegative", "ridge", "ridge_with_intercept"]

# Relative size below which an eigenvalue of the scaled Gram matrix is rounding noise.
_RANK = 1e-9


@dataclass(frozen=True)
class NormalEquations:
    """gram (k, k) = X^T W X and moment = X^T W y, (k,) or (k, c) for c right-hand sides."""

    gram: FloatArray
    moment: FloatArray
    total: float
    """Sum of W."""
    power: FloatArray
    """y^T W y, () or (c,)."""

    @classmethod
    def of(cls, x: FloatArray, y: FloatArray, weights: FloatArray) -> NormalEquations:
        """Build from rows x (n, k), targets y (n,) or (n, c), weights (n,) >= 0.

        The product runs in the precision of `x`; the sums are returned in float64.
        """
        weighted = x * weights[:, None].astype(x.dtype)
        gram = (weighted.T @ x).astype(np.float64)
        moment = (weighted.T @ y.astype(x.dtype)).astype(np.float64)
        power = np.einsum("n,n...->...", weights, np.asarray(y, dtype=np.float64) ** 2)
        return cls(gram, moment, float(weights.sum()), np.asarray(power))

    def one(self, column: int) -> NormalEquations:
        """Return the equations of one right-hand side of several."""
        return NormalEquations(self.gram, self.moment[:, column], self.total, self.power[column])


@dataclass(frozen=True)
class RidgeFit:
    """Coefficients (k, c), the damping that was used, and the degrees of freedom it leaves."""

    coefficients: FloatArray
    damping: float
    freedom: float


def ridge(equations: NormalEquations, dampings: Sequence[float]) -> RidgeFit:
    """Minimise the mean square error plus damping |a|^2 for all right-hand sides at once.

    Of several dampings the one with the smallest generalised cross-validation score wins
    (Golub, Heath, Wahba 1979): (RSS / n) / (1 - freedom / n)^2, summed over the right-hand
    sides, n being the total weight. All are judged from one eigendecomposition. Dampings
    are relative to the total weight: repeating every row changes nothing but n.
    """
    eigenvalue, vector = np.linalg.eigh(equations.gram / equations.total)
    eigenvalue = np.maximum(eigenvalue, 0.0)
    moment = vector.T @ np.atleast_2d(equations.moment.T).T / equations.total
    power = np.atleast_1d(equations.power) / equations.total
    best: tuple[float, float, float] | None = None
    for damping in dampings:
        shrink = 1.0 / (eigenvalue + damping)
        freedom = float((eigenvalue * shrink).sum())
        rss = power - ((moment**2) * (shrink * (2.0 - eigenvalue * shrink))[:, None]).sum(axis=0)
        left = max(1.0 - freedom / equations.total, 1e-3)
        score = float(np.maximum(rss, 0.0).sum()) / left**2
        if best is None or score < best[0]:
            best = (score, damping, freedom)
    assert best is not None
    coefficients = vector @ (moment / (eigenvalue + best[1])[:, None])
    return RidgeFit(coefficients.reshape(equations.moment.shape), best[1], best[2])


def nonnegative(equations: NormalEquations, free: int = 0) -> FloatArray:
    """Return a (k,) >= 0 of least square error; the last `free` coefficients may be negative.

    The Gram matrix is scaled to unit diagonal and factored by its eigenvalues, noise
    directions lifted to 1e-9 of the largest; the active-set solver is SciPy's.
    """
    scale = np.sqrt(np.maximum(np.diag(equations.gram), np.finfo(float).tiny))
    gram = equations.gram / scale[:, None] / scale
    moment = equations.moment / scale
    if free:
        # a free coefficient is the difference of two non-negative ones
        sign = np.hstack([np.eye(len(scale)), -np.eye(len(scale))[:, -free:]])
        gram, moment = sign.T @ gram @ sign, moment @ sign
    eigenvalue, vector = np.linalg.eigh(gram)
    root = np.sqrt(np.maximum(eigenvalue, _RANK * max(eigenvalue[-1], np.finfo(float).tiny)))
    factor, target = root[:, None] * vector.T, (vector.T @ moment) / root
    solution, _ = scipy.optimize.nnls(factor, target, maxiter=30 * len(moment))
    if free:
        solution = sign @ solution
    return np.asarray(solution / scale)


def ridge_with_intercept(
    x: FloatArray, y: FloatArray, weights: FloatArray, dampings: Sequence[float]
) -> tuple[FloatArray, RidgeFit]:
    """Fit y ~ intercept + x a with an undamped intercept; return (intercept (c,), fit of a).

    x (n, k), y (n, c), weights (n,) >= 0 with a positive sum. Columns are centred on their
    weighted means first, which takes the intercept out of the problem.
    """
    total = weights.sum()
    x_mean = (weights.astype(x.dtype) @ x).astype(np.float64) / total
    y_mean = weights @ y / total
    equations = NormalEquations.of(x - x_mean.astype(x.dtype), y - y_mean, weights)
    fit = ridge(equations, dampings)
    return y_mean - x_mean @ fit.coefficients, fit
