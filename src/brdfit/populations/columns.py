"""Dense log columns of a population: every member at every cell of a grid.

    columns = brdfit.populations.columns(population)     # built on first use, then read
    for start in range(0, len(columns), 4096):
        logs = columns.block(channel, start, start + 4096)     # (rows, members)
        ...
    dense = result[columns.expand]                       # one row for each of grid.cells

A column is ln max(f_r, VALUE_FLOOR). The files lie in the user's cache, shared by all
selections of the same source; only the rows that are asked for are in memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations.contract import Population
from brdfit.populations.joined_store import JoinedStore, open_stores
from brdfit.populations.store import Store, stored_cells
from brdfit.progress import Progress, silent

__all__ = ["Columns", "columns"]


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of the selected members on a grid, read from disk as they are asked for.

    Rows are the cells in `cells`. A bilateral source has only about half of the grid's
    cells there; `expand` leads from each of `grid.cells` to its row. Safe to use from
    several threads.
    """

    population: Population
    grid: Grid
    store: Store | JoinedStore

    def __len__(self) -> int:
        return int(self.cells.size)

    @cached_property
    def _layout(self) -> tuple[IntArray, IntArray]:
        return stored_cells(self.grid, self.population.source.bilateral)

    @property
    def cells(self) -> IntArray:
        """Flat grid indices of the rows, (m,), ascending."""
        return self._layout[0]

    @property
    def expand(self) -> IntArray:
        """Row of each of `grid.cells`, (grid.cells.size,)."""
        return self._layout[1]

    @cached_property
    def multiplicity(self) -> IntArray:
        """How many of `grid.cells` each row stands for, (m,): 1 or 2."""
        return np.bincount(self.expand, minlength=len(self))

    def block(self, channel: int, start: int, stop: int) -> FloatArray:
        """Return rows [start, stop) of a channel, (rows, members), float32, C-contiguous.

        `stop` may lie beyond the last row, as in a slice.
        """
        self._check_channel(channel)
        stop = min(stop, len(self))
        if not 0 <= start <= stop:
            raise UsageError(f"columns: rows {start} to {stop} of {len(self)} were asked for.")
        return self._select(self.store.read(channel, start, stop))

    def rows(self, channel: int, index: IntArray) -> FloatArray:
        """Return the rows of `index` (n,) of a channel, (n, members), float32."""
        self._check_channel(channel)
        index = np.asarray(index, dtype=np.int64)
        if index.size and not (index.min() >= 0 and index.max() < len(self)):
            raise UsageError(
                f"columns: row {index.min()} to {index.max()} was asked for but there are "
                f"{len(self)} rows; a cell's row is found by `expand`."
            )
        result = np.empty((index.size, len(self.population)), dtype=np.float32)
        for positions, values in self.store.gather(channel, index):
            result[positions] = self._select(values)
        return result

    def load(self, channel: int) -> FloatArray:
        """Return all rows of a channel, (m, members), float32: hundreds of MB on a MERL grid."""
        return self.block(channel, 0, len(self))

    def _select(self, values: FloatArray) -> FloatArray:
        if len(self.population) == self.store.members:
            return values
        return np.take(values, self.population.pick, axis=1)

    def _check_channel(self, channel: int) -> None:
        if not 0 <= channel < len(self.population.channels):
            raise UsageError(
                f"columns: channel {channel} was asked for but {self.population.name!r} has "
                f"{len(self.population.channels)} ({', '.join(self.population.channels)})."
            )


def columns(population: Population, grid: Grid = MERL_GRID, progress: Progress = silent) -> Columns:
    """Return the columns of `population` on `grid`, built first where the cache has none.

    Raises `PopulationError` where the disk has no room for them.
    """
    return Columns(population, grid, open_stores(population.source, grid, progress))
