"""Population and local residual as one linear system, and what a solution says elsewhere.

    ln f_r(x) = m(x) + F(x) z + e(x),     z ~ N(0, I),     e ~ GP(0, k)

with F = [B G | tau] of `prior` and k of `kernel`. `Whole` hangs the residual on every row: n
unknowns, exact. `Sparse` hangs it on some of the rows Z, the inducing points,

    psi(x) = k(x, Z) L^-T,     k(Z, Z) = L L^T

r + 1 + |Z| unknowns whatever the number of rows; what psi cannot tell of k(x, x) stays in the
variance. Either way the result is m + F z + k(x, Z) alpha.

Reference: J. Quinonero-Candela, C. E. Rasmussen, "A Unifying View of Sparse Approximate Gaussian
Process Regression", JMLR 6, 2005 (Sparse is its deterministic conditional with full variance).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.linalg import CoefficientPosterior, CovariancePosterior, forward
from brdfit.reconstruct.posterior.kernel import Angles, Kernel, taken
from brdfit.reconstruct.posterior.prior import PopulationPrior
from brdfit.reconstruct.posterior.refine import Posterior

__all__ = ["Solution", "Sparse", "System", "Whole"]

# Share of a^2 that k(Z, Z) is raised by on its diagonal: points may coincide.
_JITTER = 1e-8


@dataclass(frozen=True, eq=False)
class Solution:
    """z (r + 1, c), and alpha (m, c) of the residual's centres."""

    population: FloatArray
    local: FloatArray


@dataclass(frozen=True, eq=False)
class Whole:
    """Every row is a centre: exact, and n^3."""

    prior: PopulationPrior
    kernel: Kernel
    features: FloatArray
    """F (n, r + 1)."""
    angles: Angles
    population_gram: FloatArray
    """F F^T (n, n): the same for all kernels."""

    @property
    def centres(self) -> Angles:
        """The rows."""
        return self.angles

    @cached_property
    def gram(self) -> FloatArray:
        """K (n, n) of population and residual together."""
        return np.asarray(self.population_gram + self.kernel.between(self.angles, self.angles))

    def weighted(self, weights: FloatArray) -> CovariancePosterior:
        """Return the posterior for rows of weights (n,)."""
        return CovariancePosterior.of(self.gram, weights)

    def solution(self, coefficients: FloatArray) -> Solution:
        """Return z and alpha."""
        return Solution(self.features.T @ coefficients, coefficients)

    def variance(self, posterior: Posterior, features: FloatArray, angles: Angles) -> FloatArray:
        """Return the variance of ln f_r (m,)."""
        assert isinstance(posterior, CovariancePosterior)
        cross = features @ self.features.T + self.kernel.between(angles, self.angles)
        own = (features**2).sum(axis=1) + self.kernel.amplitude**2
        return posterior.variance(cross, own)


@dataclass(frozen=True, eq=False)
class Sparse:
    """Some rows are centres."""

    prior: PopulationPrior
    kernel: Kernel
    features: FloatArray
    """F (n, r + 1)."""
    angles: Angles
    chosen: IntArray
    """Rows that are centres (m,)."""

    @property
    def centres(self) -> Angles:
        """The chosen rows."""
        return taken(self.angles, self.chosen)

    @cached_property
    def factor(self) -> FloatArray:
        """L (m, m), lower."""
        gram = self.kernel.between(self.centres, self.centres)
        gram[np.diag_indices_from(gram)] += _JITTER * self.kernel.amplitude**2
        return np.linalg.cholesky(gram)

    @cached_property
    def rows(self) -> FloatArray:
        """[F | psi] (n, r + 1 + m)."""
        return np.hstack([self.features, self._local(self.angles)])

    def weighted(self, weights: FloatArray) -> CoefficientPosterior:
        """Return the posterior for rows of weights (n,)."""
        return CoefficientPosterior.of(self.rows, weights)

    def solution(self, coefficients: FloatArray) -> Solution:
        """Return z and alpha."""
        from scipy.linalg import solve_triangular

        of_population, of_residual = np.split(coefficients, [self.prior.size])
        local = solve_triangular(self.factor, of_residual, lower=True, trans="T")
        return Solution(of_population, local)

    def variance(self, posterior: Posterior, features: FloatArray, angles: Angles) -> FloatArray:
        """Return the variance of ln f_r (m,)."""
        assert isinstance(posterior, CoefficientPosterior)
        local = self._local(angles)
        untold = self.kernel.amplitude**2 - (local**2).sum(axis=1)
        told = posterior.variance(np.hstack([features, local]))
        return np.asarray(told + np.maximum(untold, 0.0))

    def _local(self, angles: Angles) -> FloatArray:
        """Return psi (n, m)."""
        return np.ascontiguousarray(
            forward(self.factor, self.kernel.between(self.centres, angles)).T
        )


System = Whole | Sparse
"""Rows of a fit under one prior and one kernel."""
