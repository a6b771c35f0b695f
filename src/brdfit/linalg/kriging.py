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
from brdfit.linalg.gaussian import TOLERANCE, LeftOut, conjugate_gradients
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

        Columns that lack entries have a B of their own: they are solved by conjugate gradients,
        all together, with the shared inverse to guide them, to a relative `tolerance`, from
        `start` (n, c), if given.
        """
        root = self.root[:, None]
        whole = np.ones(y.shape[1], dtype=bool) if known is None else known.all(axis=0)
        alpha = np.empty_like(y)
        alpha[:, whole] = root * self._apply(root * y[:, whole])
        if known is not None and not whole.all():
            alpha[:, ~whole] = self._of_some(
                y[:, ~whole],
                known[:, ~whole],
                tolerance,
                None if start is None else start[:, ~whole],
            )
        return alpha

    def _of_some(
        self, y: FloatArray, known: BoolArray, tolerance: float, start: FloatArray | None
    ) -> FloatArray:
        root = self.root[:, None]
        right = np.where(known, root * y, 0.0)

        def product(v: FloatArray) -> FloatArray:
            return v + np.where(known, root * (self.gram @ (root * v)), 0.0)

        def guide(v: FloatArray) -> FloatArray:
            return np.where(known, self.inverse @ v, 0.0)

        begin = guide(right) if start is None else np.where(known, start / root, 0.0)
        return np.asarray(root * conjugate_gradients(product, right, guide, begin, tolerance))

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
