"""What `Posterior` sees of samples: ln f_r in a fixed order, what is known, how it scatters.

The rows are put in an order of their own content, so that neither the order of a file nor the
number of threads decides anything. Noise has two parts: a relative one, which the fit finds,
and an absolute one at the dark end, where instruments (and decoded networks) have a floor:

    V_i = s^2 + (floor / f_i)^2 + (sigma_i / f_i)^2

with f_i the mean of a row over its channels and sigma_i the stated standard deviation, if any.

A value that is zero or negative says that the truth is not above a bound, `targets_of`. Its own
size says how wrong the entry is, and a dark channel is known no better than a small share of
the brightest one of its row (stray light, a colour outside the gamut, a matrix from sensor to
RGB). Taken for less than the channel's smallest values anywhere, such entries would pull the
whole channel into the dark.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.reconstruct.posterior.places import places
from brdfit.reconstruct.targets import Targets
from brdfit.samples import Samples

__all__ = ["Measurements", "targets_of"]

# Share of the brightest channel of a row below which another one is not known.
_DARKEST = 0.01


@dataclass(frozen=True, eq=False)
class Measurements:
    """n usable rows in canonical order; a copy of a row is not a second witness.

    | name       | shape  | meaning                                                      |
    |------------|--------|--------------------------------------------------------------|
    | `rows`     | (n,)   | which of the samples, the first of its copies                |
    | `place`    | (m,)   | row of each of the m samples, -1 where unusable              |
    | `y`        | (n, c) | ln f_r, or ln of the bound where censored; 0 where unknown   |
    | `known`    | (n, c) | there is a value or a bound                                  |
    | `censored` | (n, c) | only a bound                                                 |
    | `scatter`  | (n,)   | variance of ln f_r besides s^2                               |
    | `places`   | (n, p) | where samples scatter alike, `places`                        |
    """

    rows: IntArray
    place: IntArray
    y: FloatArray
    known: BoolArray
    censored: BoolArray
    scatter: FloatArray
    places: FloatArray

    @classmethod
    def of(cls, samples: Samples, floor: float) -> Measurements:
        """Take the usable rows of `samples`; `floor` is the absolute noise, 1/sr."""
        targets = targets_of(samples)
        usable = np.flatnonzero(targets.usable.any(axis=1))
        ordered = usable[_canonical_order(samples, usable)]
        rows, place = _without_copies(samples, ordered)
        known, censored = targets.usable[rows], targets.censored[rows]
        y = np.where(known, targets.log_value[rows], 0.0)
        level = np.exp(np.where(known, y, 0.0).sum(axis=1) / known.sum(axis=1))
        scatter = (floor / level) ** 2
        if samples.sigma is not None:
            stated = np.where(known & np.isfinite(samples.sigma[rows]), samples.sigma[rows], 0.0)
            relative = stated / np.maximum(np.exp(y), 1e-12)
            scatter += np.minimum((relative**2).sum(axis=1) / known.sum(axis=1), 100.0)
        where = places(samples.wi[rows], samples.wo[rows])
        return cls(rows, place, y, known, censored, scatter, where)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def complete(self) -> bool:
        """True if every row has a value in every channel."""
        return bool(self.known.all()) and not bool(self.censored.any())

    def informative(self, mean: FloatArray) -> BoolArray:
        """(n, c): what can say that the prediction `mean` (n, c) of ln f_r is off.

        A bound that the prediction respects has nothing to say.
        """
        return np.asarray(self.known & ~(self.censored & (mean <= self.y)))

    def take(self, index: IntArray) -> Measurements:
        """Return some of the rows."""
        return Measurements(
            self.rows[index],
            self.place,
            self.y[index],
            self.known[index],
            self.censored[index],
            self.scatter[index],
            self.places[index],
        )

    def channels(self, count: int) -> Measurements:
        """Return the same rows in `count` channels at most, evenly drawn.

        Channels of one direction say much the same: a row is one witness, however many there are.
        """
        c = self.y.shape[1]
        if c <= count:
            return self
        kept = np.unique(np.linspace(0, c - 1, count).round().astype(np.int64))
        return replace(
            self,
            y=self.y[:, kept],
            known=self.known[:, kept],
            censored=self.censored[:, kept],
        )

    def spread_out(self, count: int) -> IntArray:
        """Return the indices of about `count` rows, evenly among the canonical order."""
        n = len(self)
        if n <= count:
            return np.arange(n)
        return np.unique(np.linspace(0, n - 1, count).round().astype(np.int64))


def targets_of(samples: Samples) -> Targets:
    """Return the targets of `samples`, the bounds of censored entries raised by their rows.

    A bound is the largest of the channel's floor, the size of the value, and a hundredth of the
    row's brightest channel.
    """
    targets = Targets.of(samples)
    brightest = np.where(samples.positive, samples.value, 0.0).max(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        least = np.log(np.maximum(np.abs(samples.value), _DARKEST * brightest))
        bound = np.maximum(targets.log_value, least)
    return replace(targets, log_value=np.where(targets.censored, bound, targets.log_value))


def _canonical_order(samples: Samples, rows: IntArray) -> IntArray:
    """Order by a scrambled key of direction, then by value: the same for any permutation.

    The key jumps about, so that evenly spaced rows are a fair draw from all directions.
    """
    theta_h, theta_d, phi_d = (np.round(angle[rows], 9) for angle in samples.half_diff)
    key = np.modf(theta_h * 7919.0 + theta_d * 104729.0 + np.mod(phi_d, np.pi) * 1299709.0)[0]
    value = np.nan_to_num(samples.value[rows], nan=-1.0)
    return np.lexsort((*np.sort(value, axis=1).T, phi_d, theta_d, theta_h, key))


def _without_copies(samples: Samples, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return (rows, place) with neighbours of the same directions and values made one."""
    content = np.column_stack([*(angle[rows] for angle in samples.half_diff), samples.value[rows]])
    same = (content[1:] == content[:-1]) | (np.isnan(content[1:]) & np.isnan(content[:-1]))
    first = np.concatenate([np.ones(min(len(rows), 1), dtype=bool), ~same.all(axis=1)])
    place = np.full(len(samples), -1, dtype=np.int64)
    place[rows] = np.cumsum(first) - 1
    return rows[first], place
