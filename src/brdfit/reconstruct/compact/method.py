"""The settings of `Compact`, a fit of a block of items, and of one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from brdfit.linalg import CoefficientPosterior, one_thread
from brdfit.populations import Population, population
from brdfit.progress import Progress, silent
from brdfit.reconstruct.checks import check_above, check_count
from brdfit.reconstruct.compact.basis import LeadingBasis, leading_basis
from brdfit.reconstruct.compact.block import Block, problems
from brdfit.reconstruct.compact.model import CompactModel
from brdfit.reconstruct.compact.result import HALF, BlockResult
from brdfit.reconstruct.compact.solve import Search, solve
from brdfit.reconstruct.result import Reconstruction
from brdfit.reconstruct.targets import Targets
from brdfit.samples import Samples

__all__ = ["Compact"]


@dataclass(frozen=True)
class Compact:
    """Few coefficients, for very many items of few samples: explicit outliers, one start."""

    name: ClassVar[str] = "compact"

    population: str | Population = "embedded"
    """Materials to lean on: published, synthetic, embedded, nbrdf, an archive, or a folder."""
    components: int = 40
    """Coefficients of a channel, besides its brightness."""
    residual_amplitude: float = 0.1
    """ln f_r: how far a material may leave the population, smoothly, anywhere."""
    noise_floor: float = 1e-4
    """1/sr: absolute noise; far below it a measurement says little."""
    steps: int = 16
    """Rounds at most, after the coarse ones."""

    def __post_init__(self) -> None:
        check_count("components", self.components, 1)
        check_above("residual_amplitude", self.residual_amplitude, 0.0)
        check_above("noise_floor", self.noise_floor, 0.0)
        check_count("steps", self.steps, 1)

    def basis(self, progress: Progress = silent) -> LeadingBasis:
        """Return what every fit leans on; built on first use, then read."""
        materials = population(self.population)
        return leading_basis(materials, self.components, self.residual_amplitude, progress)

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples` (any number of channels).

        Raises `SampleError` where no sample is usable, `PopulationError` where the population
        cannot be had.
        """
        samples.require_usable()
        Targets.of(samples)  # names a channel that is dark throughout
        basis = self.basis(progress)
        found = self.fit_block(Block(samples, np.array([0, len(samples)])), basis)
        return self._reconstruction(samples, basis, found)

    @one_thread()
    def fit_block(self, block: Block, basis: LeadingBasis, to: Any = None) -> BlockResult:
        """Return the fits of all items of a block.

        `basis` is `self.basis()`. `to` makes an array of the user's library of a numpy array
        (`torch.from_numpy`, say); left out, numpy does the work. Items that cannot be fitted
        are in `failures` and have NaN everywhere.
        """
        found = BlockResult.empty(block, basis)
        for problem in problems(block, basis, self.noise_floor):
            items = problem.items if to is None else problem.items.converted(to)
            solution = solve(items, Search(steps=self.steps))
            found.put(problem, solution)
        return found

    def _reconstruction(
        self, samples: Samples, basis: LeadingBasis, found: BlockResult
    ) -> Reconstruction:
        used = np.asarray(samples.usable.any(axis=1))
        coefficients, outcome = found.coefficients[0].T, found.outcomes[0]
        assert outcome is not None  # a fit without usable samples was refused before
        mean, phi = basis.at(samples.wi[used], samples.wo[used])
        noise = found.noise[0] ** 2 + found.scatter[used]
        posterior = CoefficientPosterior.of(phi, found.responsibility[used] / noise)
        residuals = np.full(samples.value.shape, np.nan)
        fitted = mean[:, None] + phi @ coefficients
        residuals[used] = Targets.of(samples).take(used).residual(fitted)
        residuals[~samples.usable] = np.nan
        return Reconstruction(
            samples=samples,
            method=self,
            model=CompactModel(basis, coefficients, posterior),
            channel_weights=found.responsibility[:, None] * samples.usable,
            residuals=residuals,
            initial_residuals=residuals,
            outliers=used & (found.responsibility < HALF),
            outlier_rule=(
                f"more likely wrong than right given all others; noise of a good sample "
                f"{found.noise[0]:.3f} in ln f_r"
            ),
            outcome=outcome,
            iterations=int(found.steps[0]),
            population=dict(basis.population),
            history=(found.figures(0),),
        )
