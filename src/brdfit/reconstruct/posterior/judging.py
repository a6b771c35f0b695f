"""Who is believed beside samples that are near: the detail's metric, size and noise.

Repeated until the responsibilities stay where they are:

    1.  q at every row, kriged from the nearest believed rows without itself, rows of weight
        r_i u_i / V_i                                     V_i = s^2 + scatter_i
    2.  a factor g_i of all variances, from how far off the neighbours are of what *their*
        neighbours say: a peak is harder to predict than a plain, and not therefore wrong
    3.  r, u from the mixture at variance g_i (a^2 v_i + s^2) + scatter_i

Before each round the metric and s^2 / a^2 are chosen, on some rows, under which the rows that
are believed are most likely given the others, and a is what makes them as far off as they are.

The mixture is that of the second stage (`robust.mixture`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.linalg import Kriged, Neighbours
from brdfit.progress import Progress, silent
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.reconstruct.posterior.kernel import Angles, taken
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.refine import Belief
from brdfit.reconstruct.posterior.section import Section
from brdfit.robust import Mixture

__all__ = ["Crossed", "Metric", "Rows", "brought_to_rest"]

_LABEL = "detail"
_COUNT = 24
_REACH = 0.1
"""Of the kriging, in units of the metric: detail ends a few of these from the last sample."""
_ROUNDS = 10
# How far an e-fold of what the population says is, in units of the metric.
_LOBE = 0.15
# Rows that metrics and ratios are compared on.
_COMPARED = 2000
_RATIOS = (1e-4, 1e-3, 1e-2, 1e-1, 1.0)
_FIRST_RATIO = 0.1
# Rows with less responsibility are nobody's neighbour.
_HEARD = 0.2
# Mean change of a responsibility at which nothing is left to do.
_STILL = 2e-3
_LEAST, _EXPECTED = 3e-4, 0.01
# Imagined neighbours whose variances are as stated, and how large one may count.
_IMAGINED, _FURTHEST = 4.0, 30.0
# Rounds in which noise is fitted to what the stages before say, on which detail must improve.
_FITTING = 6


@dataclass(frozen=True)
class Metric:
    """Which samples are near: how much theta_h counts, and phi_d, and whether with theta_h.

    And whether it counts what the population says (`section`).
    """

    stretch: float
    around: float
    fades: bool
    section: Section | None = None

    def places(self, angles: Angles) -> FloatArray:
        """Return (n, 4), a column more with `section`."""
        theta_h, theta_d, _ = angles
        r = self.around * np.sin(theta_d)
        if self.fades:
            r = r * np.sin(theta_h)
        places = half_diff_features(*angles, radius=r)
        places[:, 0] *= self.stretch
        if self.section is None:
            return places
        return np.column_stack([places, _LOBE * self.section.at(theta_h, theta_d)])


_METRICS = (
    Metric(1.0, 0.06, False),
    Metric(2.0, 0.12, False),
    Metric(1.0, 0.25, True),
    Metric(2.0, 0.5, True),
)


@dataclass(frozen=True, eq=False)
class Rows:
    """What the stages before leave over, and where."""

    data: Measurements
    mean: FloatArray
    """(n, c), of the stages before."""
    angles: Angles
    left_over: FloatArray
    """y - mean (n, c); 0 where unknown."""
    whole: BoolArray
    """(n,): every channel has a value. A bound, or half a row, is nobody's neighbour."""
    section: Section | None
    """What the population alone says; None where that is not known."""

    @classmethod
    def of(
        cls,
        data: Measurements,
        mean: FloatArray,
        angles: Angles,
        section: Section | None = None,
    ) -> Rows:
        """Return the rows of `data`, of which `mean` is said."""
        whole = np.asarray((data.known & ~data.censored).all(axis=1))
        left_over = np.where(data.known, data.y - mean, 0.0)
        return cls(data, mean, angles, left_over, whole, section)

    def __len__(self) -> int:
        return len(self.data)

    def pool(self, belief: Belief) -> IntArray:
        """Return who may be a neighbour."""
        r = np.where(self.whole, belief.responsibility, 0.0)
        return np.flatnonzero(r >= min(_HEARD, 0.5 * float(r.max())))

    @cached_property
    def compared(self) -> IntArray:
        """Some of the rows, evenly drawn."""
        return self.data.spread_out(_COMPARED)


@dataclass(frozen=True, eq=False)
class Weighed:
    """What the mixture makes of a prediction: who is believed, and how far off the rest is."""

    belief: Belief
    scale: float
    """Of the variances that were stated, a^2."""
    size: FloatArray
    """(of the pool,): squares over the variance that was stated for them, times credit."""
    spread: FloatArray
    """Variance of every row (n,), noise and local factor included."""
    log_likelihood: FloatArray


@dataclass(frozen=True, eq=False)
class Crossed:
    """What near rows say of every row, and who is then believed."""

    metric: Metric
    ratio: float
    """s^2 / a^2."""
    pool: IntArray
    system: Neighbours
    kriged: Kriged
    weighed: Weighed
    gain: float = 0.0
    """ln likelihood of a sample over that without detail, mean."""

    @property
    def belief(self) -> Belief:
        """Who is believed, and s."""
        return replace(self.weighed.belief, width=self.amplitude * float(np.sqrt(self.ratio)))

    @property
    def amplitude(self) -> float:
        """How far detail goes, a, ln f_r."""
        return float(np.sqrt(self.weighed.scale))

    def factor_of(self, kriged: Kriged) -> FloatArray:
        """Return g (m,) where `kriged` is."""
        weight = self.weighed.belief.responsibility[self.pool]
        return _factor(weight, self.weighed.size, kriged.neighbours)

    def surprise(self, rows: Rows) -> FloatArray:
        """Return z^2 (n, c), NaN unknown."""
        prediction = rows.mean + self.kriged.mean
        known = rows.data.informative(prediction)
        squares = (rows.left_over - self.kriged.mean) ** 2 / self.weighed.spread[:, None]
        return np.where(known, squares, np.nan)


def brought_to_rest(rows: Rows, belief: Belief, progress: Progress = silent) -> Crossed | None:
    """Return the explanation of `rows` by near rows, or None if they are as likely without."""
    first = _at_first(rows, replace(belief, width=max(belief.width, _EXPECTED)))
    belief = first
    metric, ratio, scale = _METRICS[0], _FIRST_RATIO, first.width**2 / _FIRST_RATIO
    last: Crossed | None = None
    for step in range(_ROUNDS):
        progress(_LABEL, step, _ROUNDS)
        metric, ratio, found = _chosen(rows, belief, metric, ratio, scale)
        scale = max(float(np.clip(found, 0.25 * scale, 4.0 * scale)), _LEAST**2 / ratio)
        last = _crossed(rows, belief, metric, ratio, scale)
        change = last.belief.responsibility - belief.responsibility
        belief, scale = last.belief, last.weighed.scale
        if float(np.abs(change).mean()) < _STILL:
            break
    progress(_LABEL, _ROUNDS, _ROUNDS)
    assert last is not None
    gain = float((last.weighed.log_likelihood - _without(rows, last, first)).mean())
    return replace(last, gain=gain) if gain > 0.0 else None


def _at_first(rows: Rows, belief: Belief) -> Belief:
    """Judge by the stages before, at twice their noise."""
    data = rows.data
    known = data.informative(rows.mean)
    spread = (2.0 * belief.width) ** 2 * belief.unevenness.factor(data.places) + data.scatter
    verdict = belief.mixture.judge(data.y, rows.mean, spread, known)
    return Belief(verdict.responsibility, belief.width, belief.mixture, verdict.credit)


def _system(rows: Rows, pool: IntArray, metric: Metric, nugget: FloatArray) -> Neighbours:
    places = metric.places(rows.angles)[pool]
    return Neighbours.of(places, rows.left_over[pool], nugget, _REACH, _COUNT)


def _nugget(rows: Rows, belief: Belief, pool: IntArray, ratio: float, scale: float) -> FloatArray:
    """Return the noise of the pool (m,) over a^2."""
    weight = np.maximum(belief.responsibility * belief.credit, 1e-3)[pool]
    return np.asarray((ratio + rows.data.scatter[pool] / scale) / weight)


def _own(count: int, pool: IntArray) -> IntArray:
    """Return the place of every row in the pool (n,), or -1."""
    own = np.full(count, -1)
    own[pool] = np.arange(pool.size)
    return own


def _chosen(
    rows: Rows, belief: Belief, metric: Metric, ratio: float, scale: float
) -> tuple[Metric, float, float]:
    """Return metric, s^2 / a^2 and a^2 under which left-out rows are most likely."""
    pool, some = rows.pool(belief), rows.compared
    own = _own(len(rows), pool)[some]
    heard = belief.responsibility[some] * rows.whole[some]

    def tried(system: Neighbours, metric: Metric, ratio: float) -> tuple[float, float]:
        system = replace(system, nugget=_nugget(rows, belief, pool, ratio, scale))
        places = metric.places(taken(rows.angles, some))
        kriged = system.at(places, own)
        square = ((rows.left_over[some] - kriged.mean) ** 2).mean(axis=1)
        shape = kriged.variance + ratio + rows.data.scatter[some] / scale
        return _likelihood(square, shape, heard, belief.mixture)

    nugget = _nugget(rows, belief, pool, ratio, scale)

    def nearness(metric: Metric) -> tuple[float, Neighbours]:
        system = _system(rows, pool, metric, nugget)
        return tried(system, metric, ratio)[0], system

    systems = {one: nearness(one) for one in _METRICS}
    metric = max(systems, key=lambda one: systems[one][0])
    if rows.section is not None:
        following = replace(metric, section=rows.section)
        systems[following] = nearness(following)
        metric = max(metric, following, key=lambda one: systems[one][0])
    system = systems[metric][1]
    found = {one: tried(system, metric, one) for one in _RATIOS}
    ratio = max(_RATIOS, key=lambda one: found[one][0])
    return metric, ratio, found[ratio][1]


def _likelihood(
    square: FloatArray, shape: FloatArray, heard: FloatArray, mixture: Mixture
) -> tuple[float, float]:
    """Return (ln likelihood, scale) of inliers of variances scale * shape (n,)."""
    total = max(float(heard.sum()), 1e-9)
    relative = square / shape
    scale = max(float(heard @ relative) / total, 1e-12)
    for _ in range(8):
        credit = mixture.credit(square, scale * shape)
        scale = max(float(heard @ (credit * relative)) / total, 1e-12)
    return float(heard @ mixture.log_inlier(square, scale * shape)), scale


def _crossed(rows: Rows, belief: Belief, metric: Metric, ratio: float, scale: float) -> Crossed:
    pool = rows.pool(belief)
    system = _system(rows, pool, metric, _nugget(rows, belief, pool, ratio, scale))
    kriged = system.at(metric.places(rows.angles), _own(len(rows), pool))
    shape = kriged.variance + ratio
    found = _weighed(rows, belief, pool, kriged, shape, scale, _LEAST**2 / ratio)
    return Crossed(metric, ratio, pool, system, kriged, found)


def _weighed(
    rows: Rows,
    belief: Belief,
    pool: IntArray,
    kriged: Kriged,
    shape: FloatArray,
    scale: float,
    least: float,
) -> Weighed:
    """Judge what is kriged, of variances scale * shape (n,); the scale is made to fit."""
    data = rows.data
    prediction = rows.mean + kriged.mean
    known = data.informative(prediction)
    square = ((rows.left_over - kriged.mean) ** 2).mean(axis=1)
    stated = scale * shape + data.scatter
    heard = belief.responsibility * rows.whole
    size = belief.mixture.credit(square, stated) * square / stated
    fits = float(np.clip(heard @ size / max(float(heard.sum()), 1e-9), 0.25, 4.0))
    scale = max(scale * fits, least)
    size = np.minimum(size / fits, _FURTHEST)[pool]
    factor = _factor(belief.responsibility[pool], size, kriged.neighbours)
    spread = factor * (scale * shape) + data.scatter
    verdict = belief.mixture.judge(data.y, prediction, spread, known)
    mixture = belief.mixture.updated(data.y, verdict, known)
    belief = Belief(verdict.responsibility, belief.width, mixture, verdict.credit)
    return Weighed(belief, scale, size, spread, verdict.log_likelihood)


def _factor(weight: FloatArray, size: FloatArray, neighbours: IntArray) -> FloatArray:
    """Return g (m,): what the squares of the neighbours are in units of what was stated."""
    of_size = (weight * size)[neighbours].sum(axis=1) + _IMAGINED
    return np.asarray(of_size / (weight[neighbours].sum(axis=1) + _IMAGINED))


def _without(rows: Rows, last: Crossed, first: Belief) -> FloatArray:
    """Return ln likelihood of every row by the stages before, on the same terms.

    Some of the rows decided what those say: they look likelier than rows that are left out.
    """
    nothing = replace(last.kriged, mean=np.zeros_like(last.kriged.mean))
    before = replace(first, mixture=last.belief.mixture)
    shape = np.ones(len(rows))
    scale = first.width**2
    for _ in range(_FITTING):
        found = _weighed(rows, before, last.pool, nothing, shape, scale, _LEAST**2)
        before, scale = found.belief, found.scale
    return found.log_likelihood
