"""Kriging from nearest neighbours: what the k nearest rows say of a place, however many rows.

    y(x) = e(x) + noise,     e ~ GP(0, a^2 kappa(d / reach)),     noise_i ~ N(0, a^2 nugget_i)

    w = (kappa(Z, Z) + diag nugget)^-1 kappa(Z, x),     mean = w^T y_Z,     v = 1 - w^T kappa(Z, x)

Z are the k rows nearest to x; kappa(d) = (1 + sqrt(3) d) exp(-sqrt(3) d). Rows that are further
away are hidden behind them. The cost is n k^3, and every place stands alone: neither the order
of the places nor the number of threads changes a bit. Array operations are the definition; where
numba is installed, a compiled loop (`neighbour_loops`) does the same, faster.

Reference: A. V. Vecchia, "Estimation and model identification for continuous spatial processes",
JRSS B 50(2), 1988, 297-312.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray

__all__ = ["Kriged", "Neighbours"]

# Places whose systems are built and solved together: they stay in the cache.
_TOGETHER = 256
_THREADS = 2


@dataclass(frozen=True, eq=False)
class Kriged:
    """What the neighbours say: mean (m, c), v (m,) in units of a^2, who they are (m, k)."""

    mean: FloatArray
    variance: FloatArray
    neighbours: IntArray


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Rows at `places` (n, d) with `values` (n, c) and `nugget` (n,) > 0."""

    places: FloatArray
    values: FloatArray
    nugget: FloatArray
    reach: float
    count: int
    """k, or all other rows, if there are fewer."""
    tree: Any
    """Of the places."""

    @classmethod
    def of(
        cls,
        places: FloatArray,
        values: FloatArray,
        nugget: FloatArray,
        reach: float,
        count: int,
    ) -> Neighbours:
        """Put the rows in order."""
        from scipy.spatial import cKDTree

        places, values, nugget = (
            np.ascontiguousarray(a, dtype=np.float64) for a in (places, values, nugget)
        )
        return cls(places, values, nugget, reach, count, cKDTree(places))

    def __len__(self) -> int:
        return len(self.places)

    def at(self, places: FloatArray, own: IntArray | None = None) -> Kriged:
        """Return what is said of `places` (m, d).

        `own` (m,) is the row that a place is, which then has no say, or -1.
        """
        starts = range(0, len(places), _TOGETHER)

        def part(start: int) -> tuple[FloatArray, FloatArray, IntArray]:
            rows = slice(start, start + _TOGETHER)
            mine = None if own is None else own[rows]
            index, distance = self._nearest(places[rows], mine)
            return (*self._solved(index, distance), index)

        with ThreadPoolExecutor(_THREADS) as pool:
            parts = list(pool.map(part, starts))
        k = min(self.count, len(self) - (own is not None))
        nothing = (
            np.empty((0, self.values.shape[1])),
            np.empty(0),
            np.empty((0, k), dtype=np.int64),
        )
        mean, variance, index = zip(nothing, *parts, strict=True)
        return Kriged(np.concatenate(mean), np.concatenate(variance), np.concatenate(index))

    def _nearest(self, places: FloatArray, own: IntArray | None) -> tuple[IntArray, FloatArray]:
        """Return (index, distance), each (m, k)."""
        if own is None:
            distance, index = self.tree.query(places, np.arange(1, min(self.count, len(self)) + 1))
            return index, distance
        distance, index = self.tree.query(places, np.arange(1, min(self.count + 1, len(self)) + 1))
        # of k + 1, oneself is left out, or the furthest
        is_own = index == own[:, None]
        is_own[~is_own.any(axis=1), -1] = True
        shape = (len(index), index.shape[1] - 1)
        return index[~is_own].reshape(shape), distance[~is_own].reshape(shape)

    def _solved(self, index: IntArray, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
        loop = _loop_if_compiled()
        if loop is None:
            return self.plain_solved(index, distance)
        mean, variance = np.empty((len(index), self.values.shape[1])), np.empty(len(index))
        scale = np.sqrt(3.0) / self.reach
        loop(self.places, self.values, self.nugget, index, distance, scale, mean, variance)
        return mean, variance

    def plain_solved(self, index: IntArray, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mean (m, c) and v (m,) of rows `index` (m, k) at `distance` (m, k)."""
        k = index.shape[1]
        z = self.places[index]
        squares = np.zeros((len(index), k, k))
        for axis in range(z.shape[2]):
            difference = z[:, :, None, axis] - z[:, None, :, axis]
            difference *= difference
            squares += difference
        gram = _matern(np.sqrt(squares, out=squares), self.reach)
        gram[:, np.arange(k), np.arange(k)] += self.nugget[index]
        cross = _matern(distance.copy(), self.reach)
        weights = np.linalg.solve(gram, cross[:, :, None])[:, :, 0]
        mean = np.einsum("mk,mkc->mc", weights, self.values[index])
        variance = 1.0 - np.einsum("mk,mk->m", weights, cross)
        return mean, np.clip(variance, 0.0, 1.0)


@lru_cache(maxsize=1)
def _loop_if_compiled() -> Callable[..., None] | None:
    """Return the compiled `neighbour_loops.solve_each`; None without numba."""
    try:
        from brdfit.linalg.neighbour_loops import solve_each
    except ImportError:
        return None
    return solve_each  # type: ignore[no-any-return]


def _matern(d: FloatArray, reach: float) -> FloatArray:
    """Return kappa(d / reach); `d` is written over."""
    d *= np.sqrt(3.0) / reach
    falling = np.exp(-d)
    d += 1.0
    d *= falling
    return d
