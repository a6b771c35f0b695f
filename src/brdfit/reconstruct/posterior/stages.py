"""The two stages of a fit: what the population can explain, then what it cannot.

1. The population alone, from several starts; that is kept which goes on to the most likely
   explanation, as it stood halfway: by then it is too sure of itself.
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

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.linalg import CoefficientPosterior
from brdfit.progress import Progress, silent
from brdfit.reconstruct.posterior.choice import best_kernel
from brdfit.reconstruct.posterior.kernel import Kernel
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.prior import PopulationPrior, closer, population_prior
from brdfit.reconstruct.posterior.refine import Belief, Explanation, refine
from brdfit.reconstruct.posterior.search import Design, Search
from brdfit.reconstruct.posterior.section import Section
from brdfit.reconstruct.posterior.starts import WIDE, starting_beliefs
from brdfit.reconstruct.posterior.systems import Sparse, System
from brdfit.reconstruct.posterior.winner import Winner, at_rest, merit, whole
from brdfit.robust import Background, Mixture

__all__ = ["FREEDOM", "Judged", "everybody", "explain", "verdict_on"]

FREEDOM = 2.5
"""nu of an inlier of the second stage."""
# Mean difference of responsibilities below which two explanations are one.
_SAME = 0.01
_LABEL = "posterior"
_CHUNK = 4096
_THREADS = 2


@dataclass(frozen=True, eq=False)
class Judged:
    """Of every row: whether it is believed (n,), and the fitted ln f_r (n, c)."""

    responsibility: FloatArray
    mean: FloatArray


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
    return at_rest(data, design, system, belief, search.last_steps, search.patience)


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
    leading = prior.leading(min(search.leading, max(3, len(data) // search.rows_per_direction)))
    candidates = np.column_stack([columns, base])
    first = _by_population(data, design, leading, candidates, search)
    progress(_LABEL, 1, 2)
    weights = _closer_weights(design, columns, first, search)
    prior = population_prior(design.axes, weights, design.sizes())
    section = _section(data, design, prior, first, search)
    found = _with_residual(data, design, prior, first, section, search)
    progress(_LABEL, 2, 2)
    return found


def _by_population(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    candidates: FloatArray,
    search: Search,
) -> Explanation:
    base, features = prior.log_mean(design.components), prior.features(design.components)
    weighted = partial(CoefficientPosterior.of, features)
    found = _apart(
        [
            refine(data, base, weighted, belief, search.first_steps)
            for belief in starting_beliefs(data, candidates, search.starts)
        ]
    )
    if len(found) == 1:
        return found[0]

    def promise(explained: Explanation) -> float:
        return refine(data, base, weighted, explained.belief, search.proving_steps).score

    return max(found, key=promise)


def _apart(found: list[Explanation]) -> list[Explanation]:
    """Return those that do not believe the same samples as a likelier one, likeliest first."""
    kept: list[Explanation] = []
    for one in sorted(found, key=lambda explained: -explained.score):
        r = one.belief.responsibility
        if all(np.abs(r - other.belief.responsibility).mean() > _SAME for other in kept):
            kept.append(one)
    return kept


def _section(
    data: Measurements,
    design: Design,
    prior: PopulationPrior,
    first: Explanation,
    search: Search,
) -> Section | None:
    """Return what members like the material say of it where light and camera are equally high.

    None where the first stage believes hardly anybody. `prior` leans on those members: the whole
    population has rings and holes where nobody measured.
    """
    if first.belief.responsibility.mean() < search.heard:
        return None
    base, features = prior.log_mean(design.components), prior.features(design.components)
    weighted = partial(CoefficientPosterior.of, features)
    found = refine(data, base, weighted, first.belief, search.section_steps)
    combination, constant = prior.combination(found.coefficients)
    return Section(design.section @ combination.mean(axis=1) + constant.mean())


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
    section: Section | None,
    search: Search,
) -> Winner:
    """Return the better of two explanations; each start has a thread of its own."""

    def settled(belief: Belief) -> Winner:
        belief = replace(belief, mixture=replace(belief.mixture, freedom=FREEDOM))
        kernel = best_kernel(data, design, prior, belief, section, search)
        system = _system(data, design, prior, kernel, belief, search)
        return at_rest(data, design, system, belief, search.second_steps, search.patience)

    with ThreadPoolExecutor(_THREADS) as pool:
        found = list(pool.map(settled, (first.belief, everybody(data))))
    return max(found, key=merit)


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
        return whole(design, prior, kernel)
    believed = np.flatnonzero(belief.responsibility >= min(0.5, belief.responsibility.max()))
    chosen = believed[np.linspace(0, believed.size - 1, search.centres).round().astype(np.int64)]
    features = prior.features(design.components)
    return Sparse(prior, kernel, features, design.angles, np.unique(chosen))


def everybody(data: Measurements) -> Belief:
    """Return the belief that every sample is right."""
    mixture = Mixture(0.05, Background.of(data.y, data.known))
    return Belief(np.ones(len(data)), WIDE, mixture, np.ones(len(data)))
