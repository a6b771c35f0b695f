"""Non-negative combination of a population: the global basis, and every initial estimate.

    g(rho~(x)) = sum_j alpha_j g(M_j(x)) (+ constant where g = ln),    alpha_j >= 0

with g the error metric's encoding (`brdfit.transform`). After Matusik et al. 2003, Ren et
al. 2011 and Ali et al. 2013, who combine the materials of the MERL database.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.linalg import NormalEquations, nonnegative
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.targets import Targets, pooled
from brdfit.robust import cauchy
from brdfit.transform import ErrorMetric

__all__ = [
    "Combination",
    "RobustStart",
    "combine",
    "encode_members",
    "fit_combination",
    "fit_weighted",
    "nearest_member",
    "some_rows",
]

# Of the draw of samples for a robust start: the same samples give the same result.
_SEED = 1409


@dataclass(frozen=True)
class RobustStart:
    """How an initial estimate is kept from being dragged away by outliers."""

    scale: float = 0.3
    """ln units: residuals well above it hardly count (Cauchy weight)."""
    iterations: int = 4
    """Reweighted fits after the start from the nearest member."""
    rows: int = 20_000
    """Samples that it looks at, drawn at random from more: a hundred coefficients need no more."""


@dataclass(frozen=True, eq=False)
class Combination:
    """Fitted coefficients (c, k) for c channels, the constant of the log domain last."""

    metric: ErrorMetric
    roles: IntArray
    coefficients: FloatArray

    def log_value(self, rows: MemberRows) -> FloatArray:
        """Return ln of the combination, (m, c)."""
        result = np.empty((len(rows), len(self.roles)), dtype=np.float32)
        for role in np.unique(self.roles):
            channels = np.flatnonzero(self.roles == role)
            log = rows.logs[role]
            result[:, channels] = combine(log, self.metric, self.coefficients[channels])
        return result


def combine(log: FloatArray, metric: ErrorMetric, coefficients: FloatArray) -> FloatArray:
    """Return ln of combinations (m, c) of members (m, k) by coefficients (c, k) or (c, k + 1)."""
    k = log.shape[1]
    combined = metric.encode(log) @ coefficients[:, :k].T.astype(log.dtype)
    if metric.needs_constant:
        combined += coefficients[:, k].astype(log.dtype)
    return metric.decode(combined)


def encode_members(log: FloatArray, metric: ErrorMetric) -> FloatArray:
    """Return the design (m, k) of encoded members, (m, k + 1) with a constant where needed."""
    x = metric.encode(log)
    if not metric.needs_constant:
        return x
    return np.concatenate([x, np.ones((len(x), 1), dtype=x.dtype)], axis=1)


def fit_combination(
    rows: MemberRows,
    targets: Targets,
    roles: IntArray,
    metric: ErrorMetric,
    robust: RobustStart | None,
    per_channel: bool = False,
) -> Combination:
    """Fit each channel by the members' channel `roles` names.

    Without `robust` this is plain least squares over all positive values, as published.
    With it, the nearest single member up to a scale starts, and Cauchy-weighted fits follow.
    """
    if robust is None:
        known = targets.usable & ~targets.censored
        return _Problem(rows, targets, roles, metric).solve(known.astype(np.float64))
    some = some_rows(targets, robust.rows)
    rows, targets = rows.take(some), targets.take(some)
    problem = _Problem(rows, targets, roles, metric)
    combination = problem.nearest(robust.scale)
    for _ in range(robust.iterations):
        log_estimate = combination.log_value(rows)
        known = targets.informative(log_estimate)
        weight = cauchy(np.where(known, targets.residual(log_estimate), 0.0), robust.scale)
        combination = problem.solve(pooled(weight, known, per_channel))
    return combination


def fit_weighted(
    rows: MemberRows,
    targets: Targets,
    roles: IntArray,
    metric: ErrorMetric,
    weights: FloatArray,
) -> Combination:
    """Fit with given weights (n, c) in [0, 1], at as many samples as a robust start looks at."""
    some = some_rows(targets, RobustStart.rows)
    return _Problem(rows.take(some), targets.take(some), roles, metric).solve(weights[some])


def some_rows(targets: Targets, most: int) -> IntArray | slice:
    """Return all rows, or of more than `most` so many usable ones, always the same draw."""
    if len(targets.usable) <= most:
        return slice(None)
    usable = np.flatnonzero(targets.usable.any(axis=1))
    return np.sort(np.random.default_rng(_SEED).permutation(usable)[:most])


def nearest_member(
    rows: MemberRows, targets: Targets, roles: IntArray, metric: ErrorMetric
) -> Combination:
    """Return for each channel the one member that is nearest to it up to a scale."""
    return _Problem(rows, targets, roles, metric).nearest(RobustStart().scale)


@dataclass(frozen=True, eq=False)
class _Problem:
    rows: MemberRows
    targets: Targets
    roles: IntArray
    metric: ErrorMetric

    def solve(self, weights: FloatArray) -> Combination:
        """Weighted non-negative least squares; channels of equal weights share a Gram matrix."""
        encoded = self.metric.encode(np.where(self.targets.usable, self.targets.log_value, 0.0))
        k = self.rows.members + int(self.metric.needs_constant)
        coefficients = np.zeros((len(self.roles), k))
        for role in np.unique(self.roles):
            x = encode_members(self.rows.logs[role], self.metric)
            of_role = np.flatnonzero(self.roles == role)
            for channels in equal_columns(weights, of_role):
                self._solve_group(x, encoded, weights, channels, coefficients)
        return Combination(self.metric, self.roles, coefficients)

    def _solve_group(
        self,
        x: FloatArray,
        encoded: FloatArray,
        weights: FloatArray,
        channels: IntArray,
        coefficients: FloatArray,
    ) -> None:
        weight = weights[:, channels[0]]
        used = weight > 0.0
        if not used.any():
            return
        equations = NormalEquations.of(x[used], encoded[np.ix_(used, channels)], weight[used])
        free = int(self.metric.needs_constant)
        coefficients[channels] = nonnegative(equations, free).T

    def nearest(self, scale: float) -> Combination:
        """Return for each channel the member nearest to it, scaled to its median.

        Nearest by the mean of ln(1 + (residual / scale)^2), which outliers cannot own.
        """
        k = self.rows.members
        coefficients = np.zeros((len(self.roles), k + int(self.metric.needs_constant)))
        for channel, role in enumerate(self.roles):
            known = self.targets.usable[:, channel] & ~self.targets.censored[:, channel]
            if not known.any():
                continue
            difference = self.targets.log_value[known, channel, None] - self.rows.logs[role][known]
            log_factor = np.median(difference, axis=0)
            cost = np.log1p(((difference - log_factor) / scale) ** 2).mean(axis=0)
            best = int(np.argmin(cost))
            coefficients[channel, best] = 1.0
            factor = self.metric.encode(log_factor[best])
            coefficients[channel, k if self.metric.needs_constant else best] = factor
        return Combination(self.metric, self.roles, coefficients)


def equal_columns(weights: FloatArray, channels: IntArray) -> list[IntArray]:
    """Group `channels` by equal columns of `weights` (n, c)."""
    groups: dict[bytes, list[int]] = {}
    for channel in channels:
        groups.setdefault(weights[:, channel].tobytes(), []).append(int(channel))
    return [np.array(group) for group in groups.values()]
