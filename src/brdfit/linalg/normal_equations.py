"""Least squares from normal equations: ridge, and non-negative by Lawson and Hanson.

Minimise (X a - y)^T W (X a - y) given only gram = X^T W X and moment = X^T W y. Forming
them touches the n rows once; everything after is k x k, so that many problems that share
rows (leave-one-out, colour channels) share the work.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # its parts are imported when they are first used

from brdfit.arrays import FloatArray
from brdfit.errors import FitError

__all__ = ["NormalEquations", "RidgeFit", "nonnegative", "ridge", "ridge_with_intercept"]

# Tried in turn on the diagonal of a Gram matrix of unit diagonal.
_LIFTS = (1e-9, 1e-7, 1e-5, 1e-3)


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
        # Rooted weights on both sides make the product symmetric: half the work of any other.
        root = np.sqrt(weights)
        scaled = x * root[:, None].astype(x.dtype)
        gram = (scaled.T @ scaled).astype(np.float64)
        moment = (scaled.T @ (y.T * root).T.astype(x.dtype)).astype(np.float64)
        power = np.einsum("n,n...->...", weights, np.asarray(y, dtype=np.float64) ** 2)
        return cls(gram, moment, float(weights.sum()), np.asarray(power))

    def __add__(self, other: NormalEquations) -> NormalEquations:
        """Return the equations of the rows of both."""
        return NormalEquations(
            self.gram + other.gram,
            self.moment + other.moment,
            self.total + other.total,
            self.power + other.power,
        )

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
    are relative to the total weight, and above 0: repeating every row changes nothing but n.
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
    """Return a >= 0 of least square error, (k,) or (k, c) like the moment.

    The last `free` coefficients may be negative. The Gram matrix is scaled to unit diagonal
    and factored once for all right-hand sides; the active-set solver is SciPy's (Lawson and
    Hanson 1974). Raises `FitError` where the equations are not finite, or do not come to an end.
    """
    scale = np.sqrt(np.maximum(np.diag(equations.gram), np.finfo(float).tiny))
    gram = equations.gram / scale[:, None] / scale
    moment = equations.moment.reshape(len(scale), -1) / scale[:, None]
    factor = _factor(gram)
    target = scipy.linalg.solve_triangular(factor, moment, trans="T", check_finite=False)
    sign = np.eye(len(scale))
    if free:
        # a free coefficient is the difference of two non-negative ones
        sign = np.hstack([sign, -sign[:, -free:]])
    columns = factor @ sign
    try:
        solutions = [
            scipy.optimize.nnls(columns, column, maxiter=30 * len(sign))[0] for column in target.T
        ]
    except RuntimeError as error:
        raise FitError(
            f"non-negative least squares of {len(scale)} columns did not end within "
            f"{30 * len(sign)} steps: columns are nearly equal. Leave some out."
        ) from error
    result = sign @ np.stack(solutions, axis=1) / scale[:, None]
    return np.asarray(result.reshape(equations.moment.shape))


def _factor(gram: FloatArray) -> FloatArray:
    """Return upper triangular R with R^T R = gram, lifted as little as makes it definite.

    Gram matrices of nearly equal columns, summed in single precision, have eigenvalues that
    rounding made negative.
    """
    for lift in _LIFTS if np.isfinite(gram).all() else ():
        try:
            lifted = gram + lift * np.eye(len(gram))
            return np.asarray(scipy.linalg.cholesky(lifted, check_finite=False))
        except scipy.linalg.LinAlgError:
            continue
    raise FitError(
        f"a Gram matrix of {len(gram)} columns is not positive semidefinite even when lifted by "
        f"{_LIFTS[-1]:g}: the design holds values that are not finite."
    )


def ridge_with_intercept(
    x: FloatArray, y: FloatArray, weights: FloatArray, dampings: Sequence[float]
) -> tuple[FloatArray, RidgeFit]:
    """Fit y ~ intercept + x a with an undamped intercept; return (intercept (c,), fit of a).

    x (n, k), y (n, c), weights (n,) >= 0 with a positive sum. The weighted means are taken
    out of the sums, which takes the intercept out of the problem without a centred copy of x.
    """
    raw = NormalEquations.of(x, y, weights)
    x_mean = (weights.astype(x.dtype) @ x).astype(np.float64) / raw.total
    y_mean = weights @ y / raw.total
    centred = NormalEquations(
        raw.gram - raw.total * np.outer(x_mean, x_mean),
        raw.moment - raw.total * np.outer(x_mean, y_mean),
        raw.total,
        raw.power - raw.total * y_mean**2,
    )
    fit = ridge(centred, dampings)
    return y_mean - x_mean @ fit.coefficients, fit
