"""Linear Gaussian inference from a covariance: as many unknowns as there are rows.

    y = f + noise,     f ~ N(0, K),     noise_i ~ N(0, 1 / w_i)

    B = I + W^1/2 K W^1/2,   alpha = W^1/2 B^-1 W^1/2 y,   E f(x) = k(x, X) alpha
    var f(x) = k(x, x) - k(x, X) W^1/2 B^-1 W^1/2 k(X, x)

The same answers as `CoefficientPosterior` gives for K = Phi Phi^T, and the cheaper way to them
where there are fewer rows than coefficients, or no finite number of coefficients at all.
Without row i, with v_i = (B^-1)_ii = 1 - w_i h_i and h_i the variance of f_i:

    mean_i = mu_i - (1 - v_i) / v_i (y_i - mu_i),     var_i = (1 - v_i) / (v_i w_i)

Reference: C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT
Press 2006, algorithm 2.1 and section 5.4.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.linalg.gaussian import TOLERANCE, LeftOut
from brdfit.linalg.lapack import factor_and_inverse
from brdfit.linalg.tall import forward

__all__ = ["CovariancePosterior"]

# A row of less weight than this share of the largest counts as much: it says nothing either
# way, and what the others say of it is still found by division.
_LEAST = 1e-8


@dataclass(frozen=True, eq=False)
class CovariancePosterior:
    """N(E f, Cov f) up to the right-hand side: the factor of B, and B^-1."""

    gram: FloatArray
    """K (n, n), float64."""
    root: FloatArray
    """W^1/2 (n,)."""
    factor: FloatArray
    """L (n, n), lower, B = L L^T; what is above the diagonal means nothing."""
    lower: FloatArray
    """B^-1 (n, n), its lower triangle; what is above the diagonal means nothing."""

    @cached_property
    def kept(self) -> FloatArray:
        """V (n,), in (0, 1]."""
        return np.clip(np.diagonal(self.lower), 1e-9, 1.0)

    @cached_property
    def inverse(self) -> FloatArray:
        """B^-1 (n, n)."""
        whole = np.tril(self.lower, -1)
        whole += whole.T
        whole[np.diag_indices_from(whole)] = np.diagonal(self.lower)
        return whole

    @classmethod
    def of(cls, gram: FloatArray, weights: FloatArray) -> CovariancePosterior:
        """Factorise B for the covariance `gram` (n, n) and rows of weights (n,), >= 0."""
        weights = np.maximum(weights, max(_LEAST * float(weights.max(initial=0.0)), 1e-300))
        root = np.sqrt(weights)
        b = gram * root
        b *= root[:, None]
        b[np.diag_indices_from(b)] += 1.0
        factor, inverse = factor_and_inverse(b)
        return cls(gram, root, factor, inverse)

    def solve(
        self,
        y: FloatArray,
        known: BoolArray | None = None,
        tolerance: float = TOLERANCE,
        start: FloatArray | None = None,
    ) -> FloatArray:
        """Return alpha (n, c) from y (n, c), where `known` (n, c) says which entries are there.

        Columns that lack entries have a B of their own, of the rows K that they know; with M
        the others,

            (B_KK)^-1 = (B^-1)_KK - (B^-1)_KM ((B^-1)_MM)^-1 (B^-1)_MK

        That is exact: `tolerance` and `start` are for those who iterate.
        """
        root = self.root[:, None]
        whole = np.ones(y.shape[1], dtype=bool) if known is None else known.all(axis=0)
        alpha = np.empty_like(y)
        alpha[:, whole] = self._apply(root * y[:, whole])
        if known is not None and not whole.all():
            some = known[:, ~whole]
            alpha[:, ~whole] = self._of_some(np.where(some, root * y[:, ~whole], 0.0), some)
        alpha *= root
        return alpha

    def _of_some(self, right: FloatArray, known: BoolArray) -> FloatArray:
        """Return B_KK^-1 b (n, c), every column with its own K; b (n, c) is 0 where unknown."""
        found = self.inverse @ right
        for column, there in enumerate(known.T):
            (rows,), (missing,) = np.nonzero(there), np.nonzero(~there)
            if missing.size <= rows.size:
                across = self.inverse[missing]
                told = np.linalg.solve(across[:, missing], found[missing, column])
                found[:, column] -= told @ across
            else:
                root = self.root[rows]
                b = self.gram[np.ix_(rows, rows)] * root * root[:, None]
                b[np.diag_indices_from(b)] += 1.0
                found[rows, column] = np.linalg.solve(b, right[rows, column])
        return np.where(known, found, 0.0)

    def fitted(self, alpha: FloatArray) -> FloatArray:
        """Return E f (n, c) at the rows."""
        return np.asarray(self.gram @ alpha)

    def left_out(self, y: FloatArray, mean: FloatArray) -> LeftOut:
        """Return what the other rows say of each, from y and the fitted mean, both (n, c)."""
        odds = (1.0 - self.kept) / self.kept
        return LeftOut(mean - odds[:, None] * (y - mean), odds / self.root**2)

    def variance(self, cross: FloatArray, own: FloatArray) -> FloatArray:
        """Return var f (m,) from k(x, X) (m, n) and k(x, x) (m,)."""
        half = forward(self.factor, (cross * self.root).T)
        return np.asarray(np.maximum(own - np.einsum("nm,nm->m", half, half), 0.0))

    def _apply(self, right: FloatArray) -> FloatArray:
        from scipy.linalg import cho_solve

        return np.asarray(cho_solve((self.factor, True), right, check_finite=False))
