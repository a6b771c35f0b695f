"""Many small robust fits side by side: two components for every row, few coefficients.

For every item, with phi(x_i) the features of row i and y_ic its values (c over channels),

    y_ic = mean_i + phi_i^T z_c + noise,   z_c ~ N(0, I),   V_i = s^2 + scatter_i

and with probability pi a row is an outlier, whose values know of no prediction. Repeated:

    1.  w_i = r_i / V_i,   A = I + Phi^T W Phi,   E z = A^-1 Phi^T W (y - mean)
    2.  what the *other* rows say of each row:  h_i = phi_i^T A^-1 phi_i,
        mean_i - w_i h_i / (1 - w_i h_i) (y_i - mean_i)   and variance   h_i / (1 - w_i h_i)
    3.  r from the mixture at that variance + V_i, means over the known channels of a row
    4.  pi and s from r; s never falls by more than half, so that the first verdicts are mild

The first steps use the leading features only: they tell the outliers, cheaply. An item that has
come to rest is not touched again, whatever its neighbours do: the answer of an item does not
depend on the block it is in. `linalg.gaussian` says the same of one item, and so does
`robust.mixture` but for a second kind of outlier, the value times a factor, which this has not.

Written against the Python array API standard (2023.12 with the linear algebra extension).
Arrays of one library go in, arrays of the same library come out.

| axis | meaning                                                                        |
|------|--------------------------------------------------------------------------------|
| b    | items                                                                          |
| g    | groups of channels that share their weights: 1, or one for each channel        |
| m    | channels of a group                                                            |
| n    | rows (samples) of an item; those that say nothing have weight 0                |
| k    | features                                                                       |
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

from array_api_compat import array_namespace, device

from brdfit.reconstruct.compact.products import Products, products_of

__all__ = ["Items", "Search", "Solution", "solve"]

# An array of whichever library: no static type names them all.
Array = Any

WIDE, EXPECTED = 0.25, 0.05
"""ln f_r: noise that the search begins with; noise that is expected of good samples."""
_IMAGINED, _LEAST, _MOST = 5.0, 0.003, 0.25
# Pseudo-counts of the share of outliers, and the share that the search begins with.
_PRIOR_WRONG, _PRIOR_RIGHT, _SHARE = 0.5, 4.5, 0.05
_SETTLED, _SAME_WIDTH = 1e-2, 0.02
_LOG_TWO_PI = math.log(2.0 * math.pi)
# Below this share of items still moving, those at rest are set aside.
_CROWDED = 0.9
# ln odds of an outlier beyond which nobody doubts; axes so short that a loop adds them faster.
_HOPELESS, _SHORT = 500.0, 8


@dataclass(frozen=True)
class Search:
    """How long, and with how many of the features at first."""

    coarse_features: int = 13
    coarse_steps: int = 8
    steps: int = 16


@dataclass(frozen=True, eq=False)
class Items:
    """b items of n rows each.

    | name         | shape            | meaning                                              |
    |--------------|------------------|------------------------------------------------------|
    | `y`          | (b, g, m, n)     | ln f_r less the prior mean; 0 where unknown          |
    | `known`      | (b, g, m, n)     | 1 where there is a value or a bound, else 0          |
    | `bound`      | (b, g, m, n)     | 1 where there is only an upper bound, else 0         |
    | `background` | (b, g, m, n)     | ln density of the value as an outlier                |
    | `scatter`    | (b, n)           | variance of ln f_r besides s^2                       |
    | `features`   | (n, k), (b, n, k)| phi, shared by all items or not                      |
    | `spread`     | (k, k)           | what the uncertainty is averaged over                |
    """

    y: Array
    known: Array
    bound: Array
    background: Array
    scatter: Array
    features: Array
    spread: Array
    bounded: bool
    """Whether anything is a bound."""
    complete: bool
    """Whether everything is known: nothing to count, then."""

    @property
    def shared(self) -> bool:
        """Whether all items have the same directions."""
        return len(self.features.shape) == 2

    def take(self, xp: Any, index: Array) -> Items:
        """Return the items of `index`."""
        names = ["y", "known", "bound", "background", "scatter"]
        names += [] if self.shared else ["features"]
        return replace(self, **{n: xp.take(getattr(self, n), index, axis=0) for n in names})

    def converted(self, to: Callable[[Any], Array]) -> Items:
        """Return the items as arrays that `to` makes of these."""
        names = ("y", "known", "bound", "background", "scatter", "features", "spread")
        return replace(self, **{name: to(getattr(self, name)) for name in names})

    def leading(self, count: int) -> Items:
        """Return the items with their first features only."""
        return replace(
            self, features=self.features[..., :count], spread=self.spread[:count, :count]
        )


@dataclass(frozen=True, eq=False)
class Solution:
    """What is known of b items; every field has b along its first axis."""

    coefficients: Array
    """E z (b, g, m, k)."""
    responsibility: Array
    """r (b, n) in [0, 1]; 0 for rows that say nothing."""
    width: Array
    """s (b,), ln f_r."""
    share: Array
    """pi (b,)."""
    deviation: Array
    """(b,) root mean square of the standard deviation of ln f_r over `spread`."""
    steps: Array
    """(b,) steps taken, as floats."""
    settled: Array
    """(b,) True where the last step changed next to nothing."""

    def take(self, xp: Any, index: Array) -> Solution:
        """Return the items of `index`."""
        return _each(lambda array: xp.take(array, index, axis=0), self)


def solve(items: Items, search: Search) -> Solution:
    """Return the solution of every item."""
    xp = array_namespace(items.y)
    start = _start(xp, items)
    if search.coarse_features < items.features.shape[-1]:
        coarse = items.leading(search.coarse_features)
        start = _run(xp, coarse, start, search.coarse_steps)
    return _run(xp, items, start, search.steps)


def _start(xp: Any, items: Items) -> Solution:
    """Believe everybody."""
    b, g, m, _ = items.y.shape
    rows = xp.max(items.known, axis=(1, 2))
    like: dict[str, Any] = {"dtype": items.y.dtype, "device": device(items.y)}
    one, nothing = xp.ones(b, **like), xp.zeros((b, g, m, items.features.shape[-1]), **like)
    return Solution(nothing, rows, WIDE * one, _SHARE * one, one, 0.0 * one, one < 0.0)


def _run(xp: Any, items: Items, start: Solution, steps: int) -> Solution:
    """Step until everything rests or `steps` are done; items at rest stay as they are."""
    z = _resized(xp, start.coefficients, items.features.shape[-1])
    nobody = start.steps < 0.0
    now = replace(start, coefficients=z, steps=0.0 * start.steps, settled=nobody)
    index = xp.arange(items.y.shape[0], device=device(items.y))
    products = _products(xp, items)
    # What is known hangs on the step where bounds are.
    known = None if items.bounded else _Known.of(xp, items, items.known)
    parts: list[Solution] = []
    places: list[Array] = []
    moving = index.shape[0]
    for step in range(1, steps + 1):
        fresh = _step(xp, items, products, known, now)
        now = fresh if moving == index.shape[0] else _kept(xp, now.settled, now, fresh)
        moving = int(xp.sum(xp.astype(~now.settled, xp.int64)))
        if moving == 0 or step == steps:
            break
        if moving < _CROWDED * now.settled.shape[0]:
            rest, on = xp.nonzero(now.settled)[0], xp.nonzero(~now.settled)[0]
            parts.append(now.take(xp, rest))
            places.append(xp.take(index, rest, axis=0))
            items, now = items.take(xp, on), now.take(xp, on)
            index = xp.take(index, on, axis=0)
            products = products if items.shared else _products(xp, items)
            known = None if known is None else known.take(xp, on)
    order = xp.argsort(xp.concat([*places, index]))
    joined = _joined(xp, [*parts, now])
    return joined.take(xp, order)


def _products(xp: Any, items: Items) -> Products:
    return products_of(xp, items.features, items.spread)


def _step(
    xp: Any, items: Items, products: Products, known: _Known | None, now: Solution
) -> Solution:
    """One round of the four equations above, for every item."""
    variance = (now.width**2)[:, None] + items.scatter
    known = known or _heard(xp, items, products.fitted(xp, now.coefficients))
    weights = known.only((now.responsibility / variance)[:, None, :])
    inverse, z = products.solved(xp, weights, items.y)
    size, width = _left_out(
        xp,
        _sum(xp, (items.y - products.fitted(xp, z)) ** 2, 2),
        products.variance(xp, inverse),
        weights,
        variance[:, None, :],
    )
    judged = _judge(xp, known, now.share, size, width)
    moved = xp.max(xp.abs(judged.responsibility - now.responsibility), axis=1)
    found = _width(xp, now.width, judged)
    same = xp.abs(found / now.width - 1.0) < _SAME_WIDTH
    return Solution(
        z,
        judged.responsibility,
        found,
        (known.rows - judged.believed + _PRIOR_WRONG)
        / (known.rows + (_PRIOR_WRONG + _PRIOR_RIGHT)),
        xp.sqrt(xp.mean(products.spread(xp, inverse), axis=1)),
        now.steps + 1.0,
        (moved < _SETTLED) & same,
    )


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known of every row, and how likely it is of an outlier."""

    channels: int
    """m"""
    row: Array
    """(b, n) 1 where anything is known of a row."""
    rows: Array
    """(b,) how many"""
    group: Array | None
    """(b, g, n) 1 where the group is known; its channels know alike. None: everywhere."""
    part: Array | float
    """(b, n) or a number: what a known channel counts among those of its row."""
    log_wrong: Array
    """(b, n) mean over what is known of the ln density of an outlier"""

    @classmethod
    def of(cls, xp: Any, items: Items, known: Array) -> _Known:
        """Return what is known where `known` (b, g, m, n) is 1."""
        b, g, m, n = items.y.shape
        if items.complete:
            part = 1.0 / (g * m)
            row = xp.ones((b, n), dtype=items.y.dtype, device=device(items.y))
            return cls(m, row, xp.sum(row, axis=1), None, part, part * _all(xp, items.background))
        count = _all(xp, known)
        row = xp.astype(count > 0.0, items.y.dtype)
        part = row / (count + (1.0 - row))
        log_wrong = part * _all(xp, known * items.background)
        return cls(m, row, xp.sum(row, axis=1), known[:, :, 0, :], part, log_wrong)

    def take(self, xp: Any, index: Array) -> _Known:
        """Return what is known of the items of `index`."""
        names = ["row", "rows", "log_wrong"]
        names += [] if self.group is None else ["group", "part"]
        return replace(self, **{n: xp.take(getattr(self, n), index, axis=0) for n in names})

    def only(self, array: Array) -> Array:
        """Return an array (b, g or 1, n) with 0 where the group is not known: (b, g, n)."""
        return array if self.group is None else self.group * array

    def mean(self, xp: Any, array: Array) -> Array:
        """Return the mean (b, n) over known channels of sums over those of a group (b, g, n)."""
        return self.part * _sum(xp, self.only(array), 1)


def _heard(xp: Any, items: Items, prediction: Array) -> _Known:
    """Return what is known but for bounds that a prediction respects: they have nothing to say."""
    respected = xp.astype(prediction <= items.y, items.known.dtype)
    return _Known.of(xp, items, items.known * (1.0 - items.bound * respected))


def _left_out(
    xp: Any, squared: Array, h: Array, weights: Array, variance: Array
) -> tuple[Array, Array]:
    """Return, as the other rows have it, squared residuals over their variance, and variance.

    `squared` are those of the fit itself: with w h = p, leaving a row out divides its residual
    by 1 - p and makes the variance of what is said of it h / (1 - p).
    """
    left = _at_least(xp, 1.0 - weights * h, 1e-9)
    width = h / left + variance
    return squared / (left * left * width), width


@dataclass(frozen=True, eq=False)
class _Judged:
    responsibility: Array
    """(b, n)"""
    believed: Array
    """(b,) its sum"""
    size: Array
    """(b, n) squared residual over its variance, mean over what is known"""


def _judge(xp: Any, known: _Known, share: Array, size: Array, width: Array) -> _Judged:
    """Judge rows by their size, summed over the m channels, and variance, both (b, g, n)."""
    mean_size = known.mean(xp, size)
    log_normal = mean_size + known.mean(xp, known.channels * xp.log(width)) + _LOG_TWO_PI
    odds = xp.log(share) - xp.log1p(-share)
    against = odds[:, None] + known.log_wrong + 0.5 * log_normal
    responsibility = known.row / (1.0 + xp.exp(_at_most(xp, against, _HOPELESS)))
    return _Judged(responsibility, xp.sum(responsibility, axis=1), mean_size)


def _sum(xp: Any, array: Array, axis: int) -> Array:
    """Return the sum along an axis, added one by one where it is short."""
    count = array.shape[axis]
    if count > _SHORT:
        return xp.sum(array, axis=axis)
    before = (slice(None),) * axis
    parts = [array[(*before, i, ...)] for i in range(count)]
    return sum(parts[1:], parts[0])


def _all(xp: Any, array: Array) -> Array:
    """Return the sum over all channels (b, n) of (b, g, m, n)."""
    return _sum(xp, _sum(xp, array, 2), 1)


def _width(xp: Any, width: Array, judged: _Judged) -> Array:
    """Return s (b,) for which left-out residuals are as large as they are said to be."""
    believed = judged.believed
    sure = _at_least(xp, believed, 1e-9)
    too_large = xp.sum(judged.responsibility * judged.size, axis=1) / sure
    too_large = _at_most(xp, _at_least(xp, too_large, 0.25), 4.0)
    total = believed * width**2 * too_large + _IMAGINED * EXPECTED**2
    found = xp.maximum(xp.sqrt(total / (believed + _IMAGINED)), 0.5 * width)
    return _at_most(xp, _at_least(xp, found, _LEAST), _MOST)


def _at_least(xp: Any, array: Array, limit: float) -> Array:
    return xp.maximum(array, xp.asarray(limit, dtype=array.dtype, device=device(array)))


def _at_most(xp: Any, array: Array, limit: float) -> Array:
    return xp.minimum(array, xp.asarray(limit, dtype=array.dtype, device=device(array)))


def _kept(xp: Any, mask: Array, one: Solution, other: Solution) -> Solution:
    """Return `one` where the mask (b,) is true, else `other`."""

    def pick(name: str) -> Array:
        a, b = getattr(one, name), getattr(other, name)
        return xp.where(xp.reshape(mask, (-1, *(1,) * (len(a.shape) - 1))), a, b)

    return Solution(*(pick(field.name) for field in fields(Solution)))


def _resized(xp: Any, z: Array, count: int) -> Array:
    """Return coefficients (..., k) of the first `count` features, 0 for those not known yet."""
    missing = count - z.shape[-1]
    if missing <= 0:
        return z[..., :count]
    zeros = xp.zeros((*z.shape[:-1], missing), dtype=z.dtype, device=device(z))
    return xp.concat([z, zeros], axis=-1)


def _joined(xp: Any, parts: list[Solution]) -> Solution:
    names = [field.name for field in fields(Solution)]
    return Solution(*(xp.concat([getattr(p, n) for p in parts], axis=0) for n in names))


def _each(change: Any, solution: Solution) -> Solution:
    return Solution(*(change(getattr(solution, field.name)) for field in fields(Solution)))
