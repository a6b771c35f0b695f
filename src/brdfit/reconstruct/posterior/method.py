"""The settings of `Posterior`, and a fit from samples to a reconstruction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from brdfit.linalg import one_thread
from brdfit.populations import Population, population
from brdfit.progress import Progress, silent
from brdfit.reconstruct.checks import check_above, check_count
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.outliers import FEWEST
from brdfit.reconstruct.posterior.detail import add_detail
from brdfit.reconstruct.posterior.measurements import Measurements, targets_of
from brdfit.reconstruct.posterior.model import PosteriorModel
from brdfit.reconstruct.posterior.principal import PrincipalBasis, principal_basis
from brdfit.reconstruct.posterior.search import Design, Search
from brdfit.reconstruct.posterior.stages import Judged, explain, verdict_on
from brdfit.reconstruct.result import Reconstruction, population_record
from brdfit.samples import Samples

__all__ = ["Posterior"]

# A sample that is more likely wrong than right is named.
_HALF = 0.5


@dataclass(frozen=True)
class Posterior:
    """Gaussian process on ln f_r: a population, a local residual, explicit outliers."""

    name: ClassVar[str] = "posterior"

    population: str | Population = "embedded"
    """Materials to lean on: published, synthetic, embedded, nbrdf, an archive, or a folder."""
    noise_floor: float = 1e-5
    """1/sr: absolute noise; far below it a measurement says little."""
    starts: int = 6
    """Members of the population that the search starts from, beside their mean."""
    residual_size: int = 1500
    """Samples, at most, that the local residual hangs on: how a material leaves the population."""

    def __post_init__(self) -> None:
        check_above("noise_floor", self.noise_floor, 0.0)
        check_count("starts", self.starts, 3)
        check_count("residual_size", self.residual_size, 50)

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples` (any number of channels).

        Of more than 10,000 samples as many, evenly drawn, decide population and residual, and of
        more than 100,000 as many the detail; all are judged by the result. Raises `SampleError`
        where no sample is usable, `PopulationError` where the population cannot be had.
        """
        samples.require_usable()
        materials = population(self.population)
        return self.fit_on(samples, materials, principal_basis(materials, progress), progress)

    @one_thread()
    def fit_on(
        self,
        samples: Samples,
        materials: Population,
        basis: PrincipalBasis,
        progress: Progress = silent,
    ) -> Reconstruction:
        """Return the same as `fit`, where the components of `materials` are at hand already."""
        data = Measurements.of(samples, self.noise_floor)
        wi, wo = samples.wi[data.rows], samples.wo[data.rows]
        theta_h, theta_d, phi_d = (angle[data.rows] for angle in samples.half_diff)
        design = Design(
            components=basis.at(wi, wo),
            axes=basis.axes,
            weights=basis.column_weights(materials),
            angles=(theta_h, theta_d, phi_d),
            section=basis.on_section(progress),
        )
        search = self.search()
        winner = explain(data, design, search, progress)
        judged = verdict_on(winner, data, design, search)
        detail, judged = add_detail(
            data,
            judged,
            design.angles,
            winner.explanation.belief,
            winner.system.kernel.section,
            progress,
        )
        return self._result(samples, materials, data, PosteriorModel(basis, winner, detail), judged)

    def search(self) -> Search:
        """Return what the fit tries."""
        return Search(starts=self.starts, centres=self.residual_size)

    def _result(
        self,
        samples: Samples,
        materials: Population,
        data: Measurements,
        model: PosteriorModel,
        judged: Judged,
    ) -> Reconstruction:
        explained = model.winner.explanation
        used = data.place >= 0
        place = np.where(used, data.place, 0)
        responsibility = np.where(used, judged.responsibility[place], 0.0)
        residuals = np.full(samples.value.shape, np.nan)
        residuals[used] = targets_of(samples).take(used).residual(judged.mean[place[used]])
        residuals[~samples.usable] = np.nan
        outliers = used & (responsibility < _HALF)
        return Reconstruction(
            samples=samples,
            method=self,
            model=model,
            channel_weights=responsibility[:, None] * samples.usable,
            residuals=residuals,
            initial_residuals=residuals,
            outliers=outliers,
            outlier_rule=(
                f"more likely wrong than right given all others; noise of a good sample "
                f"{model.noise:.3f} in ln f_r"
            ),
            outcome=_outcome(int(used.sum()), int(outliers.sum()), explained.settled),
            iterations=explained.steps,
            population=population_record(materials),
            history=(_figures(model),),
        )


def _outcome(usable: int, wrong: int, settled: bool) -> Outcome:
    if usable < FEWEST:
        return Outcome.TOO_FEW_SAMPLES
    if 2 * wrong > usable:
        return Outcome.MOSTLY_OUTLIERS
    return Outcome.CONVERGED if settled else Outcome.ITERATION_LIMIT


def _figures(model: PosteriorModel) -> dict[str, float]:
    winner = model.winner
    belief, kernel = model.belief, winner.system.kernel
    figures = {
        "noise": model.noise,
        "deviations_95": model.deviations(0.95),
        "outlier_share": belief.mixture.share,
        "residual_amplitude": kernel.amplitude,
        "residual_length": kernel.length,
        "residual_stretch": kernel.stretch,
        "residual_grazing": kernel.grazing,
        "residual_lobe": kernel.lobe,
        "left_out_log_likelihood": winner.explanation.score,
    }
    if model.detail is not None:
        figures["detail_amplitude"] = model.detail.amplitude
        figures["detail_log_likelihood"] = model.detail.likelihood
    return figures
