"""Linear Gaussian inference: coefficients with a standard normal prior, from weighted rows.

    y = Phi z + noise,     z ~ N(0, I),     noise_i ~ N(0, 1 / w_i)

    A = I + Phi^T W Phi,   E z = A^-1 Phi^T W y,   Cov z = A^-1

A row of weight 0 says nothing. Columns of y that share their weights share the factor of A;
entries that are missing in some columns only are taken care of by `solve`.

Without row i the prediction of y_i follows from the fit with it (h_i = phi_i^T A^-1 phi_i):

    mean_i   = mu_i - w_i h_i / (1 - w_i h_i) (y_i - mu_i)
    var_i    = h_i / (1 - w_i h_i)                             (of phi_i^T z, without noise)

Reference: C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT
Press 2006, sections 2.1 (weight space) and 5.4.2 (leave-one-out).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.linalg.tall import forward, weighted_gram

__all__ = ["TOLERANCE", "CoefficientPosterior", "LeftOut", "conjugate_gradients"]

# Relative size of the residual at which columns of their own weights are solved.
TOLERANCE = 1e-9
_STEPS = 60


@dataclass(frozen=True, eq=False)
class LeftOut:
    """What the other rows say of each row: mean (n, c), variance (n,) without noise."""

    mean: FloatArray
    variance: FloatArray


@dataclass(frozen=True, eq=False)
class CoefficientPosterior:
    """N(E z, A^-1) up to the right-hand side: the factor L of A = L L^T, lower."""

    features: FloatArray
    """Phi (n, d), float64."""
    weights: FloatArray
    """w (n,), 1 / variance of the noise, >= 0."""
    factor: FloatArray
    """L (d, d)."""

    @classmethod
    def of(cls, features: FloatArray, weights: FloatArray) -> CoefficientPosterior:
        """Factorise A for rows `features` (n, d) of weights (n,)."""
        return cls(features, weights, factor_of(weighted_gram(features, weights)))

    def solve(
        self,
        y: FloatArray,
        known: BoolArray | None = None,
        tolerance: float = TOLERANCE,
        start: FloatArray | None = None,
    ) -> FloatArray:
        """Return E z (d, c) from y (n, c), where `known` (n, c) says which entries are there.

        Where some columns lack entries of others, each column has an A of its own: they are
        solved by conjugate gradients, all together, with the shared factor to guide them, to a
        relative `tolerance`, from `start` (d, c), if given.
        """
        if known is None or bool(known.all()):
            return self.apply(self._moment(y))
        right = self._moment(np.where(known, y, 0.0))
        start = self.apply(right) if start is None else start
        return conjugate_gradients(
            lambda z: z + self._moment(np.where(known, self.features @ z, 0.0)),
            right,
            self.apply,
            start,
            tolerance,
        )

    def apply(self, right: FloatArray) -> FloatArray:
        """Return A^-1 b for b (d, c)."""
        from scipy.linalg import cho_solve

        return np.asarray(cho_solve((self.factor, True), right, check_finite=False))

    def fitted(self, coefficients: FloatArray) -> FloatArray:
        """Return Phi z (n, c)."""
        return np.asarray(self.features @ coefficients)

    def variance(self, features: FloatArray) -> FloatArray:
        """Return phi^T A^-1 phi (m,) for rows phi (m, d)."""
        half = forward(self.factor, features.T)
        return np.asarray(np.einsum("dm,dm->m", half, half))

    def left_out(self, y: FloatArray, mean: FloatArray) -> LeftOut:
        """Return what the other rows say of each, from y and the fitted mean, both (n, c)."""
        h = self.variance(self.features)
        kept = np.maximum(1.0 - self.weights * h, 1e-9)
        return LeftOut(mean - (self.weights * h / kept)[:, None] * (y - mean), h / kept)

    def _moment(self, y: FloatArray) -> FloatArray:
        return np.asarray(self.features.T @ (self.weights[:, None] * y))


def factor_of(gram: FloatArray) -> FloatArray:
    """Return lower L with L L^T = I + gram; `gram` (d, d) = Phi^T W Phi is written over."""
    from scipy.linalg import cholesky

    gram[np.diag_indices_from(gram)] += 1.0
    return np.asarray(cholesky(gram, lower=True, overwrite_a=True, check_finite=False))


def conjugate_gradients(
    product: Callable[[FloatArray], FloatArray],
    right: FloatArray,
    precondition: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    tolerance: float = TOLERANCE,
) -> FloatArray:
    """Solve A_k z_k = b_k for every column k, preconditioned; columns stop together."""
    z = start
    r = right - product(z)
    p = s = precondition(r)
    rs = np.einsum("dc,dc->c", r, s)
    goal = tolerance**2 * np.maximum(np.einsum("dc,dc->c", right, precondition(right)), 1e-300)
    for _ in range(_STEPS):
        if np.all(rs <= goal):
            break
        q = product(p)
        step = rs / np.maximum(np.einsum("dc,dc->c", p, q), 1e-300)
        z = z + step * p
        r = r - step * q
        s = precondition(r)
        following = np.einsum("dc,dc->c", r, s)
        p = s + (following / np.maximum(rs, 1e-300)) * p
        rs = following
    return z
