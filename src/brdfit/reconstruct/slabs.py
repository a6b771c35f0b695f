"""Dense results one theta_h at a time: what a step leaves in the cache, the next finds there."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.linalg import one_thread
from brdfit.progress import Progress

__all__ = ["Carried", "add_channels", "filled", "put_channels", "side_by_side"]

_LABEL = "dense result"
# Channels up to which one after the other is faster than all in their order.
_FEW = 4
# ln f_r: what is written stays within what a float32 and a renderer can hold.
_LOWEST, _HIGHEST = -30.0, 30.0


def filled(
    grid: Grid, channels: int, put: Callable[[FloatArray, int], None], progress: Progress
) -> FloatArray:
    """Return f_r (*grid.shape, channels), float32, 0 below the horizon.

    `put(logs, i)` puts ln f_r of theta_h[i] into logs (d, phi, channels); it is called from two
    threads.
    """
    result = np.empty((*grid.shape, channels), dtype=np.float32)

    def fill(i: int) -> None:
        logs = result[i]
        put(logs, i)
        np.clip(logs, _LOWEST, _HIGHEST, out=logs)
        np.exp(logs, out=logs)
        # A cell as one thing: several times faster than its channels one by one.
        cells = logs.reshape(-1, channels).view(f"V{logs.itemsize * channels}")[:, 0]
        cells[~grid.above_horizon[i].reshape(-1)] = bytes(cells.itemsize)

    progress(_LABEL, 0, grid.n_theta_h)
    side_by_side(fill, grid.n_theta_h)
    progress(_LABEL, grid.n_theta_h, grid.n_theta_h)
    return result


def side_by_side(task: Callable[[int], None], count: int) -> None:
    """Call `task` with every number below `count`: the even ones here, the odd ones beside.

    numpy lets go of the interpreter in its loops: two threads keep two cores busy.
    """

    def every_second(first: int) -> None:
        for number in range(first, count, 2):
            task(number)

    with one_thread(), ThreadPoolExecutor(1) as pool:
        beside = pool.submit(every_second, 1)
        every_second(0)
        beside.result()


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
        along_h = values
        if not np.array_equal(to_h, np.eye(len(values))):
            along_h = (to_h @ values.reshape(len(values), -1)).reshape(-1, *values.shape[1:])
        return cls(along_h, to_d, np.ascontiguousarray(to_phi.T))

    def at(self, i: int) -> FloatArray:
        """Return the function (channels, d, phi) at theta_h[i]."""
        return np.asarray(np.matmul(np.matmul(self.to_d, self.along_h[i]), self.to_phi))


def add_channels(logs: FloatArray, found: FloatArray) -> None:
    """Add found (channels, d, phi) to logs (d, phi, channels)."""
    if len(found) > _FEW:
        logs += found.transpose(1, 2, 0)
    else:
        for channel, part in enumerate(found):
            logs[..., channel] += part


def put_channels(logs: FloatArray, found: FloatArray) -> None:
    """Put found (channels, d, phi) into logs (d, phi, channels)."""
    if len(found) > _FEW:
        logs[:] = found.transpose(1, 2, 0)
    else:
        for channel, part in enumerate(found):
            logs[..., channel] = part
