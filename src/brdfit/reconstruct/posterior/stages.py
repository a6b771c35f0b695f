"""The two stages of a fit: what the population can explain, then what it cannot.

1. The population alone, from several starts; the most likely explanation is kept.
2. Population and local residual, from the first stage's verdict *and* from believing
   everybody: a lobe that no member has looks like outliers to the first stage, but its samples
   agree with one another. Every length scale and amplitude of a short list is tried; the one
   under which left-out samples are most likely wins.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.progress import Progress, silent
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.prior import PopulationPrior, closer, population_prior
from brdfit.reconstruct.posterior.refine import Belief, Explanation, refine
from brdfit.reconstruct.posterior.residual import LocalResidual, Scale
from brdfit.reconstruct.posterior.starts import WIDE, starting_beliefs
from brdfit.robust import Background, Mixture

__all__ = ["Design", "Kernel", "Search", "Winner", "explain"]

DEPARTURE = 5.0
"""Price in ln likelihood of an e-fold of residual amplitude: it decides where samples are few."""
_LABEL = "posterior"

Angles = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True)
class Kernel:
    """Length scales and amplitude of the local residual."""

    scale: Scale
    amplitude: float


@dataclass(frozen=True)
class Search:
    """What is tried, and how long."""

    kernels: tuple[Kernel, ...]
    starts: int = 6
    first_steps: int = 12
    screening_steps: int = 3
    second_steps: int = 8
    last_steps: int = 4
    rows: int = 3000
    """Samples that the search looks at; the rest join in when it is over."""
    leading: int = 80
    """Directions of the prior in the first stage, at most..."""
    rows_per_direction: int = 8
    """...and samples that each of them wants: with fewer, outliers find a place in the prior."""
    nearest: int = 10
    reach: float = 3.0
    mix: float = 0.1


@dataclass(frozen=True, eq=False)
class Design:
    """A population at the samples: [mu | B] (n, 1 + q), V (columns, q), column weights."""

    components: FloatArray
    axes: FloatArray
    weights: FloatArray
    angles: Angles

    def take(self, index: np.ndarray) -> Design:
        """Return some of the rows."""
        theta_h, theta_d, phi_d = self.angles
        return Design(
            self.components[index],
            self.axes,
            self.weights,
            (theta_h[index], theta_d[index], phi_d[index]),
        )

    def sizes(self) -> FloatArray:
        """Return the root mean square of each component (q,) at the samples."""
        squares = (self.components[:, 1:].astype(np.float64) ** 2).mean(axis=0)
        return np.asarray(np.sqrt(squares))

    def columns(self) -> FloatArray:
        """Return ln f_r (n, k) of the columns that may be leaned on."""
        used = self.axes[self.weights > 0.0].astype(np.float32)
        return np.asarray(self.components[:, :1] + self.components[:, 1:] @ used.T)


@dataclass(frozen=True, eq=False)
class Winner:
    """The explanation that was kept, the prior and the kernel that it is made of."""

    prior: PopulationPrior
    kernel: Kernel
    explanation: Explanation
    tried: int

    def features(self, components: FloatArray, angles: Angles) -> tuple[FloatArray, FloatArray]:
        """Return (base (n,), features (n, d)) at [mu | B] (n, 1 + q) and angles."""
        return _features(self.prior, self.kernel, components, angles)

    def judge(self, data: Measurements, base: FloatArray, features: FloatArray) -> Belief:
        """Return what the coefficients make of other samples than they were fitted to."""
        belief = self.explanation.belief
        mean = base[:, None] + features @ self.explanation.coefficients
        spread = self.explanation.posterior.variance(features) + belief.width**2 + data.scatter
        verdict = belief.mixture.judge(data.y, mean, spread, data.informative(mean))
        return Belief(verdict.responsibility, belief.width, belief.mixture)


def explain(
    data: Measurements, design: Design, search: Search, progress: Progress = silent
) -> Winner:
    """Return the best explanation of `data`, whose population is `design`.

    The search looks at `Search.rows` of the samples; its winner is brought to rest on all.
    """
    some = data.spread_out(search.rows)
    if len(some) < len(data):
        found = _explained(data.take(some), design.take(some), search, progress)
        base, features = found.features(design.components, design.angles)
        belief = found.judge(data, base, features)
        explained = refine(data, base, features, belief, search.last_steps)
        return replace(found, explanation=explained)
    return _explained(data, design, search, progress)


def _explained(data: Measurements, design: Design, search: Search, progress: Progress) -> Winner:
    prior = population_prior(design.axes, design.weights, design.sizes())
    columns = design.columns()
    base = prior.log_mean(design.components)
    progress(_LABEL, 0, 2)
    first = _by_population(data, design, prior, np.column_stack([columns, base]), search)
    progress(_LABEL, 1, 2)
    weights = _closer_weights(design, columns, first, search)
    prior = population_prior(design.axes, weights, design.sizes())
    found = _with_residual(data, design, prior, first, search)
    progress(_LABEL, 2, 2)
    return found


def _features(
    prior: PopulationPrior, kernel: Kernel, components: FloatArray, angles: Angles
) -> tuple[FloatArray, FloatArray]:
    """Return (base (n,), features (n, d)): population, brightness, local residual."""
    local = LocalResidual.of(kernel.scale).at(angles)
    features = np.hstack([prior.features(components), kernel.amplitude * local])
    return prior.log_mean(components), features


def _by_population(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    candidates: FloatArray,
    search: Search,
) -> Explanation:
    leading = prior.leading(min(search.leading, max(3, len(data) // search.rows_per_direction)))
    base, features = prior.log_mean(design.components), leading.features(design.components)
    found = [
        refine(data, base, features, belief, search.first_steps)
        for belief in starting_beliefs(data, candidates, search.starts)
    ]
    return max(found, key=lambda explained: explained.score)


def _closer_weights(
    design: Design, columns: FloatArray, first: Explanation, search: Search
) -> FloatArray:
    """Weigh the columns by their distance from the first stage's result, up to a scale."""
    r = first.belief.responsibility
    share = r / max(float(r.sum()), 1e-9)
    estimate = first.mean.mean(axis=1)
    difference = columns - estimate[:, None]
    difference -= share @ difference
    distances = np.zeros(design.weights.size)
    distances[design.weights > 0.0] = share @ difference**2
    return closer(design.weights, distances, search.nearest, search.reach, search.mix)


def _with_residual(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    first: Explanation,
    search: Search,
) -> Winner:
    beliefs = [first.belief, everybody(data)]
    tried: list[list[Winner]] = [[] for _ in beliefs]
    count = len(search.kernels) * len(beliefs)
    for kernel in search.kernels:
        base, features = _features(prior, kernel, design.components, design.angles)
        for found, belief in zip(tried, beliefs, strict=True):
            explained = refine(data, base, features, belief, search.screening_steps)
            found.append(Winner(prior, kernel, explained, count))
    # The best kernel of each start has its time: a start that is right may settle more slowly.
    finished = []
    for winner in (max(found, key=_merit) for found in tried):
        base, features = winner.features(design.components, design.angles)
        belief = winner.explanation.belief
        explained = refine(data, base, features, belief, search.second_steps)
        finished.append(replace(winner, explanation=explained))
    return max(finished, key=_merit)


def _merit(winner: Winner) -> float:
    """Left-out likelihood, less what a material pays for leaving its population."""
    return winner.explanation.score - DEPARTURE * float(np.log(winner.kernel.amplitude))


def everybody(data: Measurements) -> Belief:
    """Return the belief that every sample is right."""
    mixture = Mixture(0.05, Background.of(data.y, data.known))
    return Belief(np.ones(len(data)), WIDE, mixture)
