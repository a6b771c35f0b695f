"""One explanation of the samples, brought to rest: coefficients, noise, and who is believed.

Repeated until the rows, each left out, become no likelier:

    1.  w_i = r_i u_i / V_i                              V_i = s^2 + scatter_i
    2.  coefficients from rows of weight w               (`linalg.gaussian`, `linalg.kriging`)
    3.  what the *other* rows say of each row            mean_i, var_i
    4.  u from the mixture at variance var_i + V_i,
        r at var_i + V_i + s^2 (g_i - 1)                 (`robust.mixture`)
    5.  pi, s and g from r                               (`robust.unevenness`)

A row is judged by the others: with a residual free enough to follow one sample, every sample
agrees with itself. s never falls by more than half in a step, so that a good start is not
lost to a moment's confidence, and is drawn toward `EXPECTED` by a few imagined samples. Where
noise differs from place to place, s and u would go on falling long after the left-out rows are
as likely as they get; nothing that was not measured is predicted better for it. Every start
gets the same number of steps before it may end, so that none wins because it went further.

g says where everybody is further off than elsewhere: near grazing, in a narrow peak. That is
seldom noise, most often a material that changes faster than its samples tell. So g excuses
those who are off in such a place from being called wrong, and changes nothing in what they
count for: they are all that is known there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.linalg import LeftOut
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.robust import Mixture, Unevenness, mean_known

__all__ = ["Belief", "Explanation", "Posterior", "refine"]

EXPECTED = 0.05
"""ln f_r: the noise that is expected before anything is known."""
_IMAGINED = 5.0
_LEAST, _MOST = 0.003, 0.25
# Relative, where columns lack entries of others: far below what a step moves.
_PRECISE = 1e-6
# No responsibility moves by more: nothing is left to do.
_STILL = 1e-3
# A step that makes the left-out rows likelier by less, ln, a believed row, is worth nothing.
_WORTH = 0.02


@dataclass(frozen=True, eq=False)
class Belief:
    """Who is believed, and how much: where a refinement starts, and where it stands."""

    responsibility: FloatArray
    """r (n,)."""
    width: float
    """s, relative noise of an inlier, ln f_r."""
    mixture: Mixture
    credit: FloatArray
    """u (n,)."""
    unevenness: Unevenness = field(default_factory=Unevenness)
    """g, how much larger s^2 is in some places."""

    @property
    def count(self) -> float:
        """How many rows are believed."""
        return float(self.responsibility.sum())

    def take(self, index: IntArray) -> Belief:
        """Return what is believed of some of the rows."""
        return replace(self, responsibility=self.responsibility[index], credit=self.credit[index])


class Posterior(Protocol):
    """What `CoefficientPosterior` and `CovariancePosterior` have in common."""

    def solve(
        self,
        y: FloatArray,
        known: BoolArray | None = None,
        tolerance: float = ...,
        start: FloatArray | None = None,
    ) -> FloatArray:
        """Return coefficients (d, c) from y (n, c)."""

    def fitted(self, coefficients: FloatArray) -> FloatArray:
        """Return what they predict at the rows (n, c)."""

    def left_out(self, y: FloatArray, mean: FloatArray) -> LeftOut:
        """Return what the other rows say of each."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """Coefficients and what the data say of them."""

    coefficients: FloatArray
    """(d, c), of whatever the posterior is made of."""
    posterior: Posterior
    mean: FloatArray
    """Fitted ln f_r (n, c)."""
    left_out: LeftOut
    belief: Belief
    score: float
    """Sum of ln of the mixture density of every row, given the others."""
    surprise: FloatArray
    """z^2 (n, c): e^2 over the variance that was stated for it, given the others; NaN unknown."""
    steps: int
    settled: bool


def refine(
    data: Measurements,
    base: FloatArray,
    weighted: Callable[[FloatArray], Posterior],
    belief: Belief,
    steps: int,
    most: int | None = None,
) -> Explanation:
    """Return the explanation that `belief` leads to, for ln f_r = base (n,) + what is unknown.

    `weighted` gives the posterior of the unknown for weights (n,). Ends after `steps`, or later,
    when another makes the left-out rows no likelier to speak of, and then is settled; after
    `most` in any case. Ends at once where nobody is believed otherwise than before.
    """
    most = steps if most is None else most
    before: Explanation | None = None
    for step, last in enumerate(_states(data, base, weighted, belief), start=1):
        settled = before is not None and not _worth_it(before, last)
        still = before is not None and _still(before, last)
        if still or step >= most or (settled and step >= steps):
            break
        before = last
    return replace(last, steps=step, settled=settled or still)


def _worth_it(before: Explanation, last: Explanation) -> bool:
    """Whether the last step made the left-out rows likelier."""
    return last.score - before.score >= _WORTH * last.belief.count


def _still(before: Explanation, last: Explanation) -> bool:
    """Whether everybody is believed as before, at the same noise."""
    change = last.belief.responsibility - before.belief.responsibility
    same_width = abs(last.belief.width / before.belief.width - 1.0) < 0.02
    return same_width and float(np.abs(change).max(initial=0.0)) < _STILL


def _states(
    data: Measurements,
    base: FloatArray,
    weighted: Callable[[FloatArray], Posterior],
    belief: Belief,
) -> Iterator[Explanation]:
    """Yield explanation after explanation, without end."""
    y = data.y - base[:, None]
    known = data.known
    coefficients: FloatArray | None = None
    while True:
        variance = belief.width**2 + data.scatter
        posterior = weighted(belief.responsibility * belief.credit / variance)
        coefficients = posterior.solve(y, None if known.all() else known, _PRECISE, coefficients)
        fitted = posterior.fitted(coefficients)
        left_out = posterior.left_out(y, fitted)
        known = data.informative(fitted + base[:, None])
        spread = left_out.variance + data.scatter
        spread += belief.width**2 * belief.unevenness.factor(data.places)
        verdict = belief.mixture.judge(
            y + base[:, None], left_out.mean + base[:, None], spread, known
        )
        size = mean_known((y - left_out.mean) ** 2, known) / spread * verdict.credit
        believed = verdict.responsibility * known.any(axis=1)
        belief = Belief(
            verdict.responsibility,
            _width(belief.width, size, believed),
            belief.mixture.updated(data.y, verdict, known),
            belief.mixture.credit(verdict.square, left_out.variance + variance),
            belief.unevenness.updated(data.places, size, believed),
        )
        yield Explanation(
            coefficients,
            posterior,
            fitted + base[:, None],
            left_out,
            belief,
            float(verdict.log_likelihood.sum()),
            np.where(known, (y - left_out.mean) ** 2, np.nan) / spread[:, None],
            0,
            False,
        )


def _width(width: float, size: FloatArray, believed: FloatArray) -> float:
    """Return s for which left-out residuals are as large as they are said to be."""
    count = float(believed.sum())
    too_large = float((believed * size).sum()) / max(count, 1e-9)
    total = count * width**2 * np.clip(too_large, 0.25, 4.0) + _IMAGINED * EXPECTED**2
    found = float(np.sqrt(total / (count + _IMAGINED)))
    return float(np.clip(found, max(_LEAST, 0.5 * width), _MOST))
