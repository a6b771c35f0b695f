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

from brdfit.linalg import inverses

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
_CROWDED = 0.7


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
    from array_api_compat import array_namespace

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
    one = xp.ones(b, dtype=items.y.dtype)
    nothing = xp.zeros((b, g, m, items.features.shape[-1]), dtype=items.y.dtype)
    return Solution(nothing, rows, WIDE * one, _SHARE * one, one, 0.0 * one, one < 0.0)


def _run(xp: Any, items: Items, start: Solution, steps: int) -> Solution:
    """Step until everything rests or `steps` are done; items at rest stay as they are."""
    z = _resized(xp, start.coefficients, items.features.shape[-1])
    nobody = start.steps < 0.0
    now = replace(start, coefficients=z, steps=0.0 * start.steps, settled=nobody)
    index = xp.arange(items.y.shape[0])
    products = _Products.of(xp, items)
    parts: list[Solution] = []
    places: list[Array] = []
    for step in range(1, steps + 1):
        now = _kept(xp, now.settled, now, _step(xp, items, products, now))
        moving = int(xp.sum(xp.astype(~now.settled, xp.int64)))
        if moving == 0 or step == steps:
            break
        if moving < _CROWDED * now.settled.shape[0]:
            rest, on = xp.nonzero(now.settled)[0], xp.nonzero(~now.settled)[0]
            parts.append(now.take(xp, rest))
            places.append(xp.take(index, rest, axis=0))
            items, now = items.take(xp, on), now.take(xp, on)
            index = xp.take(index, on, axis=0)
            products = products if items.shared else _Products.of(xp, items)
    order = xp.argsort(xp.concat([*places, index]))
    joined = _joined(xp, [*parts, now])
    return joined.take(xp, order)


@dataclass(frozen=True, eq=False)
class _Products:
    """Phi, and of shared directions phi_i phi_i^T, flat: one product then serves all items."""

    features: Array
    outer: Array | None

    @classmethod
    def of(cls, xp: Any, items: Items) -> _Products:
        phi = items.features
        if not items.shared:
            return cls(phi[:, None, :, :], None)
        n, k = phi.shape
        return cls(phi, xp.reshape(phi[:, :, None] * phi[:, None, :], (n, k * k)))

    def gram(self, xp: Any, weights: Array) -> Array:
        """Phi^T W Phi (b, g, k, k) of weights (b, g, n)."""
        b, g, n = weights.shape
        k = self.features.shape[-1]
        if self.outer is None:
            weighted = self.features * weights[..., None]
            return xp.matmul(xp.permute_dims(weighted, (0, 1, 3, 2)), self.features)
        return xp.reshape(xp.reshape(weights, (b * g, n)) @ self.outer, (b, g, k, k))

    def moment(self, xp: Any, y: Array) -> Array:
        """Phi^T y (b, g, m, k) of weighted values (b, g, m, n)."""
        if self.outer is None:
            return xp.matmul(y, self.features)
        return self._flat(xp, y, self.features)

    def fitted(self, xp: Any, z: Array) -> Array:
        """Phi z (b, g, m, n) of coefficients (b, g, m, k)."""
        if self.outer is None:
            return xp.matmul(z, xp.permute_dims(self.features, (0, 1, 3, 2)))
        return self._flat(xp, z, xp.permute_dims(self.features, (1, 0)))

    def variance(self, xp: Any, inverse: Array) -> Array:
        """phi_i^T A^-1 phi_i (b, g, n) of inverses (b, g, k, k)."""
        if self.outer is None:
            return xp.sum(xp.matmul(self.features, inverse) * self.features, axis=-1)
        b, g, k, _ = inverse.shape
        flat = xp.reshape(inverse, (b * g, k * k)) @ xp.permute_dims(self.outer, (1, 0))
        return xp.reshape(flat, (b, g, self.features.shape[0]))

    @staticmethod
    def _flat(xp: Any, array: Array, matrix: Array) -> Array:
        b, g, m, inner = array.shape
        product = xp.reshape(array, (b * g * m, inner)) @ matrix
        return xp.reshape(product, (b, g, m, matrix.shape[1]))


def _step(xp: Any, items: Items, products: _Products, now: Solution) -> Solution:
    """One round of the four equations above, for every item."""
    variance = (now.width**2)[:, None] + items.scatter
    known = items.known
    if items.bounded:  # a bound that the last prediction respects has nothing to say
        respected = products.fitted(xp, now.coefficients) <= items.y
        known = known * (1.0 - items.bound * xp.astype(respected, known.dtype))
    weights = (now.responsibility / variance)[:, None, :] * _of_group(items, known)
    k = items.features.shape[-1]
    inverse = inverses(xp, products.gram(xp, weights) + xp.eye(k, dtype=known.dtype))
    z = xp.matmul(products.moment(xp, weights[:, :, None, :] * items.y), inverse)
    h = products.variance(xp, inverse)
    others, spread = _left_out(xp, items.y, products.fitted(xp, z), weights, h)
    spread = spread + variance[:, None, :]
    judged = _judge(xp, items, known, now.share, items.y - others, spread)
    moved = xp.max(xp.abs(judged.responsibility - now.responsibility), axis=1)
    width = _width(xp, now.width, judged)
    same = xp.abs(width / now.width - 1.0) < _SAME_WIDTH
    return Solution(
        z,
        judged.responsibility,
        width,
        (xp.sum(judged.rows - judged.responsibility, axis=1) + _PRIOR_WRONG)
        / (xp.sum(judged.rows, axis=1) + _PRIOR_WRONG + _PRIOR_RIGHT),
        _deviation(xp, inverse, items.spread),
        now.steps + 1.0,
        (moved < _SETTLED) & same,
    )


def _deviation(xp: Any, inverse: Array, spread: Array) -> Array:
    """Return (b,): root mean square of sqrt(phi^T A^-1 phi) over what `spread` averages."""
    b, g, k, _ = inverse.shape
    variance = xp.reshape(inverse, (b * g, k * k)) @ xp.reshape(spread, (k * k,))
    return xp.sqrt(xp.mean(xp.reshape(variance, (b, g)), axis=1))


def _of_group(items: Items, known: Array) -> Array | float:
    """(b, g, n): what the group knows; its channels know alike."""
    return 1.0 if items.complete else known[:, :, 0, :]


def _left_out(xp: Any, y: Array, fitted: Array, weights: Array, h: Array) -> tuple[Array, Array]:
    """Return what the other rows say: mean (b, g, m, n), variance (b, g, n) without noise."""
    kept = 1.0 - weights * h
    kept = xp.where(kept > 1e-9, kept, 1e-9 + 0.0 * kept)
    pulled = (weights * h / kept)[:, :, None, :]
    return fitted - pulled * (y - fitted), h / kept


@dataclass(frozen=True, eq=False)
class _Judged:
    rows: Array
    """(b, n) 1 where anything is known of a row."""
    responsibility: Array
    size: Array
    """(b, n) squared residual over its variance, mean over what is known."""


def _judge(
    xp: Any, items: Items, known: Array, share: Array, residual: Array, spread: Array
) -> _Judged:
    """Judge residuals (b, g, m, n) of variance (b, g, n), noise included."""
    size, width = residual**2 / spread[:, :, None, :], xp.log(spread) + _LOG_TWO_PI
    if items.complete:
        rows, mean_size = xp.ones(spread[:, 0, :].shape, dtype=size.dtype), _mean(xp, size)
        log_normal, log_wrong = mean_size + width[:, 0, :], _mean(xp, items.background)
    else:
        count = xp.sum(known, axis=(1, 2))
        rows = xp.astype(count > 0.0, known.dtype)
        count = count + (1.0 - rows)
        mean_size = xp.sum(known * size, axis=(1, 2)) / count
        log_normal = mean_size + xp.sum(known * width[:, :, None, :], axis=(1, 2)) / count
        log_wrong = xp.sum(known * items.background, axis=(1, 2)) / count
    right = xp.log1p(-share)[:, None] - 0.5 * log_normal
    wrong = xp.log(share)[:, None] + log_wrong
    responsibility = rows * xp.exp(right - xp.logaddexp(right, wrong))
    return _Judged(rows, responsibility, mean_size)


def _mean(xp: Any, array: Array) -> Array:
    """Return the mean over all channels (b, n), added one by one: the axes are short."""
    parts = [array[:, g, m, :] for g in range(array.shape[1]) for m in range(array.shape[2])]
    return sum(parts[1:], parts[0]) / len(parts)


def _width(xp: Any, width: Array, judged: _Judged) -> Array:
    """Return s (b,) for which left-out residuals are as large as they are said to be."""
    believed = xp.sum(judged.responsibility, axis=1)
    sure = xp.where(believed > 1e-9, believed, 1e-9 + 0.0 * believed)
    too_large = xp.sum(judged.responsibility * judged.size, axis=1) / sure
    total = believed * width**2 * xp.clip(too_large, 0.25, 4.0) + _IMAGINED * EXPECTED**2
    found = xp.sqrt(total / (believed + _IMAGINED))
    found = xp.where(found > 0.5 * width, found, 0.5 * width)
    return xp.clip(found, _LEAST, _MOST)


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
    return xp.concat([z, xp.zeros((*z.shape[:-1], missing), dtype=z.dtype)], axis=-1)


def _joined(xp: Any, parts: list[Solution]) -> Solution:
    names = [field.name for field in fields(Solution)]
    return Solution(*(xp.concat([getattr(p, n) for p in parts], axis=0) for n in names))


def _each(change: Any, solution: Solution) -> Solution:
    return Solution(*(change(getattr(solution, field.name)) for field in fields(Solution)))
