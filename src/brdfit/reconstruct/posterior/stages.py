"""The two stages of a fit: what the population can explain, then what it cannot.

1. The population alone, from several starts; the most likely explanation is kept.
2. Population and local residual, from the first stage's verdict *and* from believing
   everybody: a lobe that no member has looks like outliers to the first stage, but its samples
   agree with one another. Of the kernels of a short list, tried on some of the samples, the one
   under which left-out samples are most likely is brought to rest on all.

An inlier of the first stage is normal, that of the second has the tails of Student's t: the
population alone must not take an outlier for a measurement that is a little off, but beside
what its neighbours say a sample is seldom off by noise alone.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.linalg import CoefficientPosterior
from brdfit.progress import Progress, silent
from brdfit.reconstruct.posterior.kernel import Angles, Kernel, taken
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.prior import PopulationPrior, closer, population_prior
from brdfit.reconstruct.posterior.refine import Belief, Explanation, refine
from brdfit.reconstruct.posterior.starts import WIDE, starting_beliefs
from brdfit.reconstruct.posterior.systems import Solution, Sparse, System, Whole
from brdfit.robust import Background, Mixture

__all__ = ["Design", "Judged", "Search", "Winner", "explain", "verdict_on"]

DEPARTURE = 5.0
"""Price in ln likelihood of an e-fold of residual amplitude: it decides where samples are few."""
FREEDOM = 2.5
"""nu of an inlier of the second stage."""
_LABEL = "posterior"
_CHUNK = 4096
_THREADS = 2


@dataclass(frozen=True)
class Search:
    """What is tried, and how long."""

    shapes: tuple[tuple[float, float], ...] = ((0.15, 1), (0.4, 1), (0.4, 3), (1, 1), (1, 3))
    """Length and stretch of the kernels; each is tried at the first amplitude..."""
    amplitudes: tuple[float, ...] = (0.3, 0.1, 1.0)
    """...and the best of them at the others..."""
    grazing: float = 0.25
    """...and the best of those with the horizon further away."""
    starts: int = 6
    first_steps: int = 12
    screening_steps: int = 3
    second_steps: int = 8
    last_steps: int = 4
    patience: int = 2
    """Times as many are taken, in these two, while they make left-out samples likelier."""
    screening_rows: int = 500
    screening_channels: int = 6
    """Samples and channels that kernels are compared on, evenly drawn."""
    rows: int = 1000
    """Samples that the search looks at; the rest join in when it is over."""
    centres: int = 1500
    """Samples that the residual may hang on."""
    most: int = 10_000
    """Samples that decide the result; all others are judged by it."""
    leading: int = 80
    """Directions of the prior in the first stage, at most..."""
    rows_per_direction: int = 8
    """...and samples that each of them wants: with fewer, outliers find a place in the prior."""
    nearest: int = 10
    reach: float = 3.0
    mix: float = 0.01


@dataclass(frozen=True, eq=False)
class Design:
    """A population at the samples: [mu | B] (n, 1 + q), V (columns, q), column weights."""

    components: FloatArray
    axes: FloatArray
    weights: FloatArray
    angles: Angles

    def take(self, index: np.ndarray) -> Design:
        """Return some of the rows."""
        return Design(self.components[index], self.axes, self.weights, taken(self.angles, index))

    def sizes(self) -> FloatArray:
        """Return the root mean square of each component (q,) at the samples."""
        squares = (self.components[:, 1:].astype(np.float64) ** 2).mean(axis=0)
        return np.asarray(np.sqrt(squares))

    def columns(self) -> FloatArray:
        """Return ln f_r (n, k) of the columns that may be leaned on."""
        used = self.axes[self.weights > 0.0].astype(np.float32)
        return np.asarray(self.components[:, :1] + self.components[:, 1:] @ used.T)


@dataclass(frozen=True, eq=False)
class Judged:
    """Of every row: whether it is believed (n,), and the fitted ln f_r (n, c)."""

    responsibility: FloatArray
    mean: FloatArray


@dataclass(frozen=True, eq=False)
class Winner:
    """The explanation that was kept, and the system that it solves."""

    system: System
    solution: Solution
    explanation: Explanation

    @classmethod
    def of(cls, system: System, explanation: Explanation) -> Winner:
        """Return the winner whose explanation solves `system`."""
        return cls(system, system.solution(explanation.coefficients), explanation)

    def mean(self, components: FloatArray, angles: Angles) -> FloatArray:
        """Return ln f_r (n, c) at [mu | B] (n, 1 + q) and angles."""
        combination, constant = self.system.prior.combination(self.solution.population)
        of_population = components.astype(np.float64) @ combination + constant
        local = self.system.kernel.between(angles, self.system.centres) @ self.solution.local
        return np.asarray(of_population + local)

    def variance(self, components: FloatArray, angles: Angles) -> FloatArray:
        """Return that of ln f_r (n,)."""
        features = self.system.prior.features(components)
        return self.system.variance(self.explanation.posterior, features, angles)

    def prior_variance(self, components: FloatArray) -> FloatArray:
        """Return that of ln f_r before any sample, the brightness known, (n,)."""
        features = self.system.prior.features(components)[:, :-1]
        return np.asarray((features**2).sum(axis=1) + self.system.kernel.amplitude**2)

    def judge(self, data: Measurements, design: Design) -> Belief:
        """Return what the solution makes of other samples than it was fitted to."""
        belief = self.explanation.belief
        mean = self.mean(design.components, design.angles)
        spread = self.variance(design.components, design.angles)
        spread += belief.width**2 * belief.unevenness.factor(data.places) + data.scatter
        verdict = belief.mixture.judge(data.y, mean, spread, data.informative(mean))
        return replace(belief, responsibility=verdict.responsibility, credit=verdict.credit)


def explain(
    data: Measurements, design: Design, search: Search, progress: Progress = silent
) -> Winner:
    """Return the best explanation of `data`, whose population is `design`.

    The search looks at `Search.rows` of the samples; its winner is brought to rest on
    `Search.most` of them.
    """
    some = data.spread_out(search.rows)
    found = _explained(data.take(some), design.take(some), search, progress)
    if len(some) == len(data):
        return found
    many = data.spread_out(search.most)
    data, design = data.take(many), design.take(many)
    belief = found.judge(data, design)
    system = _system(data, design, found.system.prior, found.system.kernel, belief, search)
    return _at_rest(data, design, system, belief, search.last_steps, search.patience)


def verdict_on(winner: Winner, data: Measurements, design: Design, search: Search) -> Judged:
    """Return what the winner makes of all rows, those that decided it among them.

    A row that had no say is judged by the result: its variance is the median of what was left
    out among those that had one, which lie as densely.
    """
    explained = winner.explanation
    many = data.spread_out(search.most)
    if len(many) == len(data):
        return Judged(explained.belief.responsibility, explained.mean)
    responsibility, mean = np.empty(len(data)), np.empty_like(data.y)
    belief = explained.belief
    variance = float(np.median(explained.left_out.variance))

    def judge(start: int) -> None:
        rows = np.arange(start, min(start + _CHUNK, len(data)))
        part = data.take(rows)
        at = design.take(rows)
        mean[rows] = winner.mean(at.components, at.angles)
        known = part.informative(mean[rows])
        spread = variance + part.scatter
        spread += belief.width**2 * belief.unevenness.factor(part.places)
        verdict = belief.mixture.judge(part.y, mean[rows], spread, known)
        responsibility[rows] = verdict.responsibility

    with ThreadPoolExecutor(_THREADS) as pool:
        list(pool.map(judge, range(0, len(data), _CHUNK)))
    responsibility[many], mean[many] = belief.responsibility, explained.mean
    return Judged(responsibility, mean)


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


def _by_population(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    candidates: FloatArray,
    search: Search,
) -> Explanation:
    leading = prior.leading(min(search.leading, max(3, len(data) // search.rows_per_direction)))
    base, features = prior.log_mean(design.components), leading.features(design.components)
    weighted = partial(CoefficientPosterior.of, features)
    found = [
        refine(data, base, weighted, belief, search.first_steps)
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
    """Return the better of two explanations; each start has a thread of its own."""

    def settled(belief: Belief) -> Winner:
        belief = replace(belief, mixture=replace(belief.mixture, freedom=FREEDOM))
        kernel = _best_kernel(data, design, prior, belief, search)
        system = _system(data, design, prior, kernel, belief, search)
        return _at_rest(data, design, system, belief, search.second_steps, search.patience)

    with ThreadPoolExecutor(_THREADS) as pool:
        found = list(pool.map(settled, (first.belief, everybody(data))))
    return max(found, key=_merit)


def _best_kernel(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    belief: Belief,
    search: Search,
) -> Kernel:
    """Return the kernel under which left-out samples are most likely, after a few steps."""
    some = data.spread_out(search.screening_rows)
    data = data.take(some).channels(search.screening_channels)
    design, belief = design.take(some), belief.take(some)
    whole = _whole(design, prior, Kernel(1.0, 1.0, 1.0))

    def tried(kernel: Kernel) -> tuple[float, Kernel]:
        system = replace(whole, kernel=kernel)
        return _merit(_at_rest(data, design, system, belief, search.screening_steps)), kernel

    first, *others = search.amplitudes
    shapes = [tried(Kernel(length, stretch, first)) for length, stretch in search.shapes]
    best = max(shapes, key=lambda found: found[0])
    amplitudes = (tried(replace(best[1], amplitude=a)) for a in others)
    best = max(chain([best], amplitudes), key=lambda found: found[0])
    return max(best, tried(replace(best[1], grazing=search.grazing)), key=lambda found: found[0])[1]


def _at_rest(
    data: Measurements,
    design: Design,
    system: System,
    belief: Belief,
    steps: int,
    patience: int = 1,
) -> Winner:
    base = system.prior.log_mean(design.components)
    found = refine(data, base, system.weighted, belief, steps, patience * steps)
    return Winner.of(system, found)


def _system(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    kernel: Kernel,
    belief: Belief,
    search: Search,
) -> System:
    """Return the whole system if there are few enough rows, else one that hangs on some.

    These are rows that are believed, evenly among the canonical order.
    """
    if len(data) <= search.centres:
        return _whole(design, prior, kernel)
    believed = np.flatnonzero(belief.responsibility >= min(0.5, belief.responsibility.max()))
    chosen = believed[np.linspace(0, believed.size - 1, search.centres).round().astype(np.int64)]
    features = prior.features(design.components)
    return Sparse(prior, kernel, features, design.angles, np.unique(chosen))


def _whole(design: Design, prior: PopulationPrior, kernel: Kernel) -> Whole:
    features = prior.features(design.components)
    return Whole(prior, kernel, features, design.angles, features @ features.T)


def _merit(winner: Winner) -> float:
    """Left-out likelihood, less what a material pays for leaving its population."""
    price = DEPARTURE * float(np.log(winner.system.kernel.amplitude))
    return winner.explanation.score - price


def everybody(data: Measurements) -> Belief:
    """Return the belief that every sample is right."""
    mixture = Mixture(0.05, Background.of(data.y, data.known))
    return Belief(np.ones(len(data)), WIDE, mixture, np.ones(len(data)))
