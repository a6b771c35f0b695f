"""`CorrectionFunctions`: the published method (poster, "Our method").

An initial estimate from the population (`combination`) is multiplied, step by step, by
correction functions from the correction basis (`correction_basis`), with explicit weights
that take outliers out (`corrections`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.grid import Grid
from brdfit.linalg import one_thread
from brdfit.populations import Population, population
from brdfit.progress import Progress, silent
from brdfit.reconstruct.checks import check_above, check_count
from brdfit.reconstruct.combination import (
    Combination,
    RobustStart,
    fit_combination,
    fit_weighted,
    nearest_member,
)
from brdfit.reconstruct.correction_basis import CorrectionBasis, correction_basis
from brdfit.reconstruct.corrections import (
    Correction,
    CorrectionLoop,
    LoopResult,
    log_of_corrections,
)
from brdfit.reconstruct.members import MemberRows, channel_roles, on_grid
from brdfit.reconstruct.outliers import FEWEST, find_outliers
from brdfit.reconstruct.result import Reconstruction, population_record
from brdfit.reconstruct.targets import Targets
from brdfit.samples import Samples
from brdfit.transform import error_metric

__all__ = ["CorrectedCombination", "CorrectionFunctions"]

# Candidates of the generalised cross-validation. Below the lowest, outliers that are not yet
# weighted down are fitted as if they were signal; the highest makes a correction a constant.
_DAMPINGS = tuple(float(10.0**e) for e in range(-4, 1))


@dataclass(frozen=True, eq=False)
class CorrectedCombination:
    """The fitted model: rho~ = combination * sigma_1 * sigma_2 * ..."""

    population: Population
    combination: Combination
    basis: CorrectionBasis
    corrections: tuple[Correction, ...]

    def log_value(self, rows: MemberRows, basis_values: FloatArray | None = None) -> FloatArray:
        """Return ln f_r (m, c) at the members' directions.

        `basis_values` (m, K) are the correction functions there, where a caller has them.
        """
        result = self.combination.log_value(rows)
        if self.corrections:
            values = self.basis.evaluate(rows) if basis_values is None else basis_values
            result = result + log_of_corrections(self.corrections, values)
        return result

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        return np.exp(self.log_value(MemberRows.at(self.population, wi, wo)).astype(np.float64))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr; 0 below the horizon."""
        return grid.spread(
            on_grid(self.population, grid, lambda rows: np.exp(self.log_value(rows)), progress)
        )

    def stddev(self, wi: FloatArray, wo: FloatArray) -> None:
        """Return None: the published method states no uncertainty."""
        return None


@dataclass(frozen=True)
class CorrectionFunctions:
    """Robust reconstruction by correction functions (the published method)."""

    name: ClassVar[str] = "correction"

    population: str | Population = "published"
    """Materials to lean on: published, nbrdf, an archive of networks, or a folder of MERL files."""
    error_metric: str = "log"
    """Error metric of the initial estimate and of the correction basis: linear, root or log."""
    gamma: float = 16.0
    """How fast the weight of a sample falls with its relative deviation: exp(-gamma d)."""
    softening: float = 1.4
    """While the estimate is poor, gamma is lowered to this over the 20th percentile of d."""
    iterations: int = 16
    """Largest number of corrections."""
    tolerance: float = 0.005
    """A correction whose rms of ln sigma is below this ends the iteration."""
    damping: float | None = 1e-4
    """Damping of the correction's coefficients; None lets generalised cross-validation choose."""
    sigma_limit: float = 4.0
    """One correction changes no value by more than this factor."""
    robust_start: bool = True
    """Keep outliers from dragging the initial estimate away."""
    per_channel: bool = False
    """Judge each channel of a sample on its own instead of one verdict on the sample."""

    def __post_init__(self) -> None:
        error_metric(self.error_metric)
        for name, low in (("gamma", 0.0), ("softening", 0.0), ("tolerance", 0.0)):
            check_above(name, getattr(self, name), low)
        check_above("sigma_limit", self.sigma_limit, 1.0)
        check_count("iterations", self.iterations, 0)
        if self.damping is not None:
            check_above("damping", self.damping, 0.0)

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples` (any number of channels).

        Raises `SampleError` where no sample is usable, `PopulationError` where the
        population cannot be had.
        """
        samples.require_usable()
        materials = population(self.population)
        metric = error_metric(self.error_metric)
        basis = correction_basis(materials, metric, progress)
        # rows that say nothing stay out of the products: a row is rounded by its place in them
        told = np.flatnonzero(samples.usable.any(axis=1))
        part = samples.subset(told)
        rows = MemberRows.at(materials, part.wi, part.wo)
        targets = Targets.of(part)
        roles = channel_roles(samples, materials)
        combination, loop = self.fit_rows(rows, targets, roles, basis, None, progress)
        model = CorrectedCombination(materials, combination, basis, loop.corrections)
        residuals = _among_all(samples, told, _residuals(part, targets, loop.log_estimate), np.nan)
        before = _residuals(part, targets, combination.log_value(rows))
        outliers = find_outliers(residuals, samples.usable, self.per_channel)
        return Reconstruction(
            samples=samples,
            method=self,
            model=model,
            channel_weights=_among_all(samples, told, loop.weights, 0.0),
            residuals=residuals,
            initial_residuals=_among_all(samples, told, before, np.nan),
            outliers=outliers.rows,
            outlier_rule=outliers.rule,
            outcome=outliers.outcome(loop.outcome),
            iterations=len(loop.corrections),
            population=population_record(materials),
            history=loop.history,
        )

    @one_thread()
    def fit_rows(
        self,
        rows: MemberRows,
        targets: Targets,
        roles: IntArray,
        basis: CorrectionBasis,
        basis_values: FloatArray | None = None,
        progress: Progress = silent,
    ) -> tuple[Combination, LoopResult]:
        """Fit with the members already evaluated at the samples.

        For callers that fit many times at the same directions (benchmarks); `basis_values`
        (n, K) are the correction functions there, computed if left out.
        """
        few = int(targets.usable.any(axis=1).sum()) < FEWEST
        loop = CorrectionLoop(
            gamma=self.gamma,
            softening=self.softening,
            iterations=0 if few else self.iterations,
            tolerance=self.tolerance,
            dampings=_DAMPINGS if self.damping is None else (self.damping,),
            sigma_limit=self.sigma_limit,
            per_channel=self.per_channel,
        )
        if few:  # a combination, let alone a correction, would be fitted to noise
            metric = error_metric(self.error_metric)
            combination = judge = nearest_member(rows, targets, roles, metric)
        else:
            combination, judge = self._start(rows, targets, roles, loop)
        values = basis.evaluate(rows) if basis_values is None else basis_values
        result = loop.run(
            values,
            targets,
            combination.log_value(rows).astype(np.float64),
            judge.log_value(rows).astype(np.float64),
            lambda done, total: progress("corrections", done, total),
        )
        return combination, result

    def _start(
        self, rows: MemberRows, targets: Targets, roles: IntArray, loop: CorrectionLoop
    ) -> tuple[Combination, Combination]:
        """Return the initial estimate, and the combination that judges the samples for it.

        A robust start is always found in the logarithmic domain, where a bright lobe does not
        outvote the rest; its weights then keep outliers from the fit in another domain.
        """
        metric, log = error_metric(self.error_metric), error_metric("log")
        if not self.robust_start:
            combination = fit_combination(rows, targets, roles, metric, None)
            return combination, combination
        judge = fit_combination(rows, targets, roles, log, RobustStart(), self.per_channel)
        if metric == log:
            return judge, judge
        weights = loop.soft_weights(targets, judge.log_value(rows).astype(np.float64))
        return fit_weighted(rows, targets, roles, metric, weights), judge


def _among_all(
    samples: Samples, told: IntArray, values: FloatArray, otherwise: float
) -> FloatArray:
    """Return `values` of the rows `told` among those of all samples (n, c)."""
    found = np.full(samples.value.shape, otherwise)
    found[told] = values
    return found


def _residuals(samples: Samples, targets: Targets, log_estimate: FloatArray) -> FloatArray:
    return np.where(samples.usable, targets.residual(log_estimate), np.nan)
