"""Symmetric matrices as their lower triangles, row after row: half the room, half the products."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray

__all__ = ["Triangle"]

# An array of whichever library.
Array = Any


@dataclass(frozen=True, eq=False)
class Triangle:
    """Where the elements of symmetric (k, k) are among the p = k (k + 1) / 2 that are kept."""

    size: int
    """k"""
    rows: IntArray
    """(p,)"""
    columns: IntArray
    """(p,)"""
    place: IntArray
    """(k k,): which of the p stands at each place of the whole."""
    times: FloatArray
    """(p,): how often it stands in the whole, 1 or 2."""

    @staticmethod
    @lru_cache(maxsize=8)
    def of(size: int) -> Triangle:
        """Return the triangle of matrices (size, size)."""
        rows, columns = np.tril_indices(size)
        i, j = np.divmod(np.arange(size * size), size)
        low, high = np.minimum(i, j), np.maximum(i, j)
        return Triangle(
            size, rows, columns, high * (high + 1) // 2 + low, np.where(rows == columns, 1.0, 2.0)
        )

    def pack(self, xp: Any, whole: Array) -> Array:
        """Return (..., p) of symmetric (..., k, k)."""
        flat = xp.reshape(whole, (*whole.shape[:-2], self.size**2))
        return xp.take(flat, self._index(xp, self.rows * self.size + self.columns, flat), axis=-1)

    def unpack(self, xp: Any, packed: Array) -> Array:
        """Return symmetric (..., k, k) of (..., p)."""
        flat = xp.take(packed, self._index(xp, self.place, packed), axis=-1)
        return xp.reshape(flat, (*packed.shape[:-1], self.size, self.size))

    def squares(self, xp: Any, vectors: Array) -> Array:
        """Return v v^T, packed (n, p), of each of some vectors (n, k)."""
        left = xp.take(vectors, self._index(xp, self.rows, vectors), axis=-1)
        return left * xp.take(vectors, self._index(xp, self.columns, vectors), axis=-1)

    def doubled(self, xp: Any, packed: Array) -> Array:
        """Return (..., p) whose product with a packed A is the sum of A times it over the whole."""
        from array_api_compat import device

        return packed * xp.asarray(self.times, dtype=packed.dtype, device=device(packed))

    @staticmethod
    def _index(xp: Any, index: IntArray, like: Array) -> Array:
        from array_api_compat import device

        return xp.asarray(index, device=device(like))
