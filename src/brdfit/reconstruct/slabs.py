"""Dense results a few theta_h at a time: what a step leaves in the cache, the next finds there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from brdfit.arrays import FloatArray, frozen, surely_finite
from brdfit.grid import Grid
from brdfit.linalg import side_by_side
from brdfit.progress import Progress
from brdfit.reconstruct.slab_cells import HIGHEST

__all__ = ["Carried", "Put", "along_theta_h", "filled", "highest"]

Put = Callable[[slice, FloatArray], None]
"""Puts f_r of some theta_h into cells (rings, d * phi, channels), float32; 0 below the horizon.
Called from two threads."""

_LABEL = "dense result"
# Values of theta_h at once: enough that two threads seldom wait for one another to be let into
# the interpreter, and few enough that both have as much to do.
_TOGETHER = 15


def filled(grid: Grid, channels: int, put: Put, progress: Progress) -> tuple[FloatArray, bool]:
    """Return f_r (*grid.shape, channels), float32, 0 below the horizon, and if all are finite.

    That is asked where it was just put, on both threads.
    """
    result = np.empty((*grid.shape, channels), dtype=np.float32)
    cells = result.reshape(grid.n_theta_h, -1, channels)

    count = -(-grid.n_theta_h // _TOGETHER)
    finite = np.zeros(count, dtype=bool)

    def fill(number: int) -> None:
        rings = slice(number * _TOGETHER, min((number + 1) * _TOGETHER, grid.n_theta_h))
        put(rings, cells[rings])
        finite[number] = surely_finite(cells[rings])

    progress(_LABEL, 0, grid.n_theta_h)
    side_by_side(fill, count)
    progress(_LABEL, grid.n_theta_h, grid.n_theta_h)
    return result, bool(finite.all())


@lru_cache(maxsize=4)
def highest(grid: Grid) -> FloatArray:
    """Return the largest that ln f_r of each cell may be, (h, d * phi), float32.

    It is -inf below the horizon.
    """
    most = np.where(grid.above_horizon, HIGHEST, np.float32(-np.inf))
    return frozen(most.reshape(grid.n_theta_h, -1))


@dataclass(frozen=True, eq=False)
class Carried:
    """A function known at nodes along three axes, carried to the cells of a grid by products."""

    along_h: FloatArray
    """(h, channels, d nodes, phi nodes): at the grid's theta_h already"""
    to_d: FloatArray
    """(d, d nodes)"""
    to_phi: FloatArray
    """(phi nodes, phi)"""

    @classmethod
    def of(
        cls, values: FloatArray, to_h: FloatArray, to_d: FloatArray, to_phi: FloatArray
    ) -> Carried:
        """Return `values` (h nodes, channels, d nodes, phi nodes) carried along theta_h.

        The matrices are (cells along an axis, nodes along it).
        """
        return cls(along_theta_h(values, to_h), to_d, np.ascontiguousarray(to_phi.T))

    def at(self, i: int) -> FloatArray:
        """Return the function (channels, d, phi) at theta_h[i]."""
        return np.asarray(np.matmul(np.matmul(self.to_d, self.along_h[i]), self.to_phi))


def along_theta_h(values: FloatArray, matrix: FloatArray) -> FloatArray:
    """Return `values` (h nodes, ...) at other theta_h, by a matrix (h, h nodes)."""
    if np.array_equal(matrix, np.eye(len(values))):
        return values
    return np.asarray(matrix @ values.reshape(len(values), -1)).reshape(-1, *values.shape[1:])
