"""`GlobalBasis`: a non-negative combination of the population, as published.

    g(rho(x)) ~ sum_j alpha_j g(M_j(x)),    alpha_j >= 0

by plain least squares over the samples; after Matusik et al. 2003 ("A Data-Driven Reflectance
Model"), Ren et al. 2011 ("Pocket Reflectometry") and Ali et al. 2013. It has no defence
against outliers: it is here as the rival, and as the method for a material that is known to
be like those of the population.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.linalg import one_thread
from brdfit.populations import Population, population
from brdfit.progress import Progress, silent
from brdfit.reconstruct.combination import Combination, fit_combination
from brdfit.reconstruct.members import MemberRows, channel_roles, on_grid
from brdfit.reconstruct.result import Reconstruction, direct_result, population_record
from brdfit.reconstruct.targets import Targets
from brdfit.samples import Samples
from brdfit.transform import error_metric

__all__ = ["CombinationModel", "GlobalBasis"]


@dataclass(frozen=True, eq=False)
class CombinationModel:
    """A fitted combination and the population that it combines."""

    population: Population
    combination: Combination

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        log_value = self.combination.log_value(MemberRows.at(self.population, wi, wo))
        return np.exp(log_value.astype(np.float64))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr; 0 below the horizon."""
        return grid.spread(
            on_grid(
                self.population,
                grid,
                lambda rows: np.exp(self.combination.log_value(rows)),
                progress,
            )
        )

    def stddev(self, wi: FloatArray, wo: FloatArray) -> None:
        """Return None: the method states no uncertainty."""
        return None


@dataclass(frozen=True)
class GlobalBasis:
    """Non-negative combination of the population by plain least squares."""

    name: ClassVar[str] = "global"

    population: str | Population = "published"
    """Materials to combine: published, nbrdf, an archive of networks, or a folder of MERL files."""
    error_metric: str = "log"
    """Domain in which values are combined and compared: linear, root or log."""

    def __post_init__(self) -> None:
        error_metric(self.error_metric)

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples` (any number of channels).

        Censored values are left out: plain least squares has no use for a bound. Raises
        `SampleError` where no sample is usable.
        """
        samples.require_usable()
        materials = population(self.population)
        rows = MemberRows.at(materials, *samples.safe_directions)
        combination = fit_combination(
            rows,
            Targets.of(samples),
            channel_roles(samples, materials),
            error_metric(self.error_metric),
            robust=None,
        )
        return direct_result(
            self,
            samples,
            CombinationModel(materials, combination),
            combination.log_value(rows).astype(np.float64),
            population_record(materials),
        )
