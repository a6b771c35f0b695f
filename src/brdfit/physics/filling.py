"""Values for cells that nobody measured: as smooth as can be between those that were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.table import Table

__all__ = ["filled"]

_SWEEPS = 60
# A zero has no logarithm; this share of the smallest positive value stands for it.
_NOTHING = 0.1


def filled(table: Table, wrong: BoolArray | None = None) -> Table:
    """Return `table` with every cell above the horizon valid.

    Missing cells start from the nearest valid one and are then swept: ln f becomes the mean
    of its neighbours along theta_h, theta_d and phi_d (periodic), which tends to the harmonic
    function between the valid cells. `wrong`, shaped as the values, marks single values that
    are filled in their channel only. Everything else is not changed. A channel without any
    valid value is returned as it is.
    """
    exists = table.grid.above_horizon
    values = np.array(table.values)
    holes: _Holes | None = None
    for channel in range(table.n_channels):
        own = None if wrong is None or not wrong[..., channel].any() else wrong[..., channel]
        if own is not None:
            valid = table.mask & ~own
            there = _Holes.of(replace(table, valid=valid), exists & ~valid)
        else:
            there = holes = holes or _Holes.of(table, exists & ~table.mask)
        if there is not None:
            values[there.missing, channel] = there.values(table.values[..., channel])
    values.flags.writeable = False
    return replace(table, values=values, valid=exists if table.mask.any() else table.mask)


class _Holes:
    """The missing cells of a table and their six neighbours."""

    @classmethod
    def of(cls, table: Table, missing: BoolArray) -> _Holes | None:
        """Return None where nothing is missing, or there is nothing to fill from."""
        return cls(table, missing) if missing.any() and table.mask.any() else None

    def __init__(self, table: Table, missing: BoolArray) -> None:
        self.missing = missing
        self._start = table.nearest_valid.reshape(-1)[np.flatnonzero(missing)]
        shape = table.grid.shape
        at = np.stack(np.nonzero(missing))
        known = table.grid.above_horizon
        self._missing = np.flatnonzero(missing)
        self._neighbours: list[IntArray] = []
        self._counts: list[BoolArray] = []
        for axis in range(3):
            for step in (-1, 1):
                beside = at.copy()
                beside[axis] += step
                if axis == 2:
                    beside[axis] %= shape[axis]
                inside = (beside[axis] >= 0) & (beside[axis] < shape[axis])
                beside[axis] = np.clip(beside[axis], 0, shape[axis] - 1)
                flat = np.ravel_multi_index(tuple(beside), shape)
                self._neighbours.append(flat)
                self._counts.append(inside & known.reshape(-1)[flat])
        self._total = np.maximum(1, np.sum(self._counts, axis=0))
        self._valid = table.mask.reshape(-1)

    def values(self, column: FloatArray) -> FloatArray:
        """Return the values (missing cells,) of one channel."""
        start = self._start
        f = column.reshape(-1).astype(np.float64)
        positive = f[self._valid & (f > 0.0)]
        if positive.size == 0:
            return np.zeros(len(start))
        log_f = np.log(np.maximum(np.where(self._valid, f, 1.0), _NOTHING * positive.min()))
        log_f[self._missing] = log_f[start]
        for _ in range(_SWEEPS):
            total = np.zeros(len(start))
            for neighbour, counts in zip(self._neighbours, self._counts, strict=True):
                total += np.where(counts, log_f[neighbour], 0.0)
            log_f[self._missing] = total / self._total
        return np.asarray(np.exp(log_f[self._missing]))
