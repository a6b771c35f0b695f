"""The iteration of the correction-function method, on arrays.

Steps 2 to 5 of the poster, for all channels at once:

    sigma_i = rho_i / rho~_i                            correction factors
    w_i     = exp(-gamma |rho_i - rho~_i| / rho~_i)     weights
    sigma(x) = beta_0 + sum_j beta_j C_j(x)             least squares on sigma_i with w_i
    rho~   := sigma rho~

The poster writes sigma = sum_j beta_j C_j; the constant beta_0 lets the damping of the beta_j
draw sigma to a constant instead of to zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.linalg import ridge_with_intercept
from brdfit.reconstruct.combination import equal_columns, some_rows
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.targets import Targets, pooled
from brdfit.robust import relative_exponential

__all__ = ["Correction", "CorrectionLoop", "LoopResult", "log_of_corrections"]

# A single correction factor beyond this cannot be a correction; it would only pull on beta
# through what is left of its weight.
_FACTOR_LIMIT = 10.0
# Deviations count as at most this: beyond it a weight is nothing, and exp would overflow.
_DEVIATION_LIMIT = 1e3
# Samples of smaller weight are left out of the sums.
_NEGLIGIBLE = 1e-6
# Below this share of used rows it pays to pick them out.
_WORTH_PICKING = 0.5
# More samples than this are iterated on by a random part of as many; the last corrections,
# of which there are this many, see all of them.
_ENOUGH = 20_000
_LAST = 2
# Iterations without a smaller loss before the loop gives up.
_PATIENCE = 2
# Percentile of the deviations that counts as typical of the inliers: at up to 80 % outliers
# the samples below it are inliers.
_SOFT_PERCENTILE = 20.0


@dataclass(frozen=True, eq=False)
class Correction:
    """One dense correction function a channel: intercept (c,), coefficients (K, c)."""

    intercept: FloatArray
    coefficients: FloatArray
    limit: float

    def log_value(self, basis_values: FloatArray) -> FloatArray:
        """Return ln sigma (m, c) from C_j (m, K); sigma is held in [1 / limit, limit]."""
        return log_of_corrections((self,), basis_values)


def log_of_corrections(corrections: Sequence[Correction], basis_values: FloatArray) -> FloatArray:
    """Return ln (sigma_1 sigma_2 ...) (m, c) from C_j (m, K): one product for all of them."""
    dtype = basis_values.dtype
    n, limit = len(corrections), corrections[0].limit
    coefficients = np.concatenate([c.coefficients for c in corrections], axis=1).astype(dtype)
    sigma = basis_values @ coefficients
    sigma += np.concatenate([c.intercept for c in corrections]).astype(dtype)
    np.clip(sigma, 1.0 / limit, limit, out=sigma)
    return np.asarray(np.log(sigma.reshape(len(sigma), n, -1).prod(axis=1)))


@dataclass(frozen=True, eq=False)
class LoopResult:
    """Corrections in the order of application, ln rho~ at the samples, and how it ended."""

    corrections: tuple[Correction, ...]
    log_estimate: FloatArray
    weights: FloatArray
    outcome: Outcome
    history: tuple[dict[str, float], ...]

    def followed_by(self, other: LoopResult) -> LoopResult:
        """Return the result of both, one after the other; it ended as this one did."""
        done = len(self.history)
        later = (one | {"iteration": one["iteration"] + done} for one in other.history)
        return replace(
            other,
            corrections=self.corrections + other.corrections,
            outcome=self.outcome,
            history=(*self.history, *later),
        )


@dataclass(frozen=True)
class CorrectionLoop:
    """Settings of the iteration; see `CorrectionFunctions` for their meaning."""

    gamma: float
    softening: float
    iterations: int
    tolerance: float
    dampings: tuple[float, ...]
    sigma_limit: float
    per_channel: bool

    def run(
        self,
        basis_values: FloatArray,
        targets: Targets,
        log_estimate: FloatArray,
        judge: FloatArray,
        step: Callable[[int, int], None],
    ) -> LoopResult:
        """Iterate from an initial ln rho~ (n, c) with C_j at the samples (n, K).

        `judge` is a ln rho~ (n, c) that withstands outliers. As long as it is nearer to its
        inliers than the estimate is to its own, corrections are fitted with its weights.
        Of many samples a part is iterated on: a few hundred coefficients need no more. The
        last corrections are fitted to all, and weights and residuals are those of all.
        """
        some = some_rows(targets, _ENOUGH)
        if isinstance(some, slice):
            return self._iterate(basis_values, targets, log_estimate, judge, step)
        last = min(_LAST, self.iterations)
        part = replace(self, iterations=self.iterations - last)._iterate(
            basis_values[some], targets.take(some), log_estimate[some], judge[some], step
        )
        if part.corrections:
            log_estimate = log_estimate + log_of_corrections(part.corrections, basis_values)
        whole = replace(self, iterations=last)._iterate(
            basis_values, targets, log_estimate, judge, lambda done, total: None
        )
        return part.followed_by(whole)

    def _iterate(
        self,
        basis_values: FloatArray,
        targets: Targets,
        log_estimate: FloatArray,
        judge: FloatArray,
        step: Callable[[int, int], None],
    ) -> LoopResult:
        """Iterate on all of these samples.

        Keeps the iterate of the smallest robust loss, the mean of 1 - w, and stops when a
        correction is almost one everywhere or when the loss has not fallen twice in a row.
        """
        best = state = _State.of(targets, log_estimate, self)
        first = _State.of(targets, judge, self)
        corrections: list[Correction] = []
        history = [{"iteration": 0.0, "loss": state.loss}]
        kept, outcome = 0, Outcome.ITERATION_LIMIT
        for iteration in range(1, self.iterations + 1):
            step(iteration - 1, self.iterations)
            fairer = min(state, first, key=lambda one: one.typical)
            correction = self._correction(basis_values, targets, state, fairer.soft_weights)
            log_sigma = correction.log_value(basis_values)
            corrections.append(correction)
            telling = targets.informative(state.log_estimate)
            sigma_rms = float(np.sqrt(np.mean(log_sigma[telling] ** 2)))
            state = _State.of(targets, state.log_estimate + log_sigma, self)
            history.append({"iteration": iteration, "loss": state.loss, "sigma_rms": sigma_rms})
            if state.loss < best.loss:
                best, kept = state, iteration
            if sigma_rms < self.tolerance:
                outcome = Outcome.CONVERGED
                break
            if iteration - kept >= _PATIENCE:
                outcome = Outcome.NO_IMPROVEMENT
                break
        step(self.iterations, self.iterations)
        return LoopResult(
            tuple(corrections[:kept]), best.log_estimate, best.weights, outcome, tuple(history)
        )

    def soft_weights(self, targets: Targets, log_estimate: FloatArray) -> FloatArray:
        """Return the weights (n, c) with which a correction of ln rho~ (n, c) is fitted."""
        return _State.of(targets, log_estimate, self).soft_weights

    def _correction(
        self, basis_values: FloatArray, targets: Targets, state: _State, weights: FloatArray
    ) -> Correction:
        n_channels = targets.log_value.shape[1]
        intercept = np.ones(n_channels)
        coefficients = np.zeros((basis_values.shape[1], n_channels))
        fit_weights = np.where(targets.informative(state.log_estimate), weights, 0.0)
        factors = np.clip(np.exp(targets.residual(state.log_estimate)), 0.0, _FACTOR_LIMIT)
        for channels in equal_columns(fit_weights, np.arange(n_channels)):
            weight = fit_weights[:, channels[0]]
            used = weight > _NEGLIGIBLE
            if not used.any():
                continue
            # picking rows copies the largest array there is: only where it saves more, or
            # where a row holds nothing
            worth_it = used.mean() < _WORTH_PICKING or not weight.all()
            rows = used if worth_it else slice(None)
            intercept[channels], fit = ridge_with_intercept(
                basis_values[rows], factors[rows][:, channels], weight[rows], self.dampings
            )
            coefficients[:, channels] = fit.coefficients
        return Correction(intercept, coefficients, self.sigma_limit)


@dataclass(frozen=True, eq=False)
class _State:
    log_estimate: FloatArray
    weights: FloatArray
    """(n, c) in [0, 1]; 0 where unusable."""
    soft_weights: FloatArray
    """The same with gamma lowered while the estimate is still far from most samples."""
    loss: float
    typical: float
    """Relative deviation of what counts as a typical inlier."""

    @classmethod
    def of(cls, targets: Targets, log_estimate: FloatArray, loop: CorrectionLoop) -> _State:
        residual = np.where(targets.usable, targets.residual(log_estimate), 0.0)
        # |rho_i - rho~_i| / rho~_i, one verdict on all channels of a sample
        relative = np.abs(np.expm1(np.minimum(residual, np.log(_DEVIATION_LIMIT))))
        deviation = pooled(relative, targets.usable, loop.per_channel)
        weights = relative_exponential(deviation, loop.gamma) * targets.usable
        # a bound that is respected is no sign of a good estimate
        telling = deviation[targets.informative(log_estimate)]
        typical = float(np.percentile(telling, _SOFT_PERCENTILE))
        gamma = min(loop.gamma, loop.softening / max(typical, 1e-6))
        soft_weights = relative_exponential(deviation, gamma) * targets.usable
        loss = 1.0 - float(weights[targets.usable].mean())
        return cls(log_estimate, weights, soft_weights, loss, typical)
