"""Columns of a joined population: those of its parts side by side, none of them written twice."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.grid import Grid
from brdfit.populations.building import open_store
from brdfit.populations.contract import MemberSource
from brdfit.populations.joined import Joined
from brdfit.populations.store import FLOAT, Store
from brdfit.progress import Progress, silent

__all__ = ["JoinedStore", "open_stores", "stores_of"]


@dataclass(frozen=True, eq=False)
class JoinedStore:
    """What a `Store` reads, from several: the members of one after those of the other."""

    stores: tuple[Store, ...]
    """On the same grid, with the same cells."""

    @property
    def members(self) -> int:
        """Number of columns, all parts together."""
        return sum(store.members for store in self.stores)

    def read(self, channel: int, start: int, stop: int) -> FloatArray:
        """Return rows [start, stop) of a channel, (stop - start, members), float32."""
        return np.concatenate([store.read(channel, start, stop) for store in self.stores], axis=1)

    def gather(self, channel: int, index: IntArray) -> Iterator[tuple[IntArray, FloatArray]]:
        """Yield (positions in `index`, rows), once and all together."""
        rows = np.empty((index.size, self.members), dtype=FLOAT)
        first = 0
        for store in self.stores:
            columns = rows[:, first : first + store.members]
            for positions, values in store.gather(channel, index):
                columns[positions] = values
            first += store.members
        yield np.arange(index.size), rows


def stores_of(source: MemberSource, grid: Grid) -> tuple[Store, ...]:
    """Return where the columns of a source are kept: one store, or one for each of its parts.

    Parts that are not bilateral alike have other rows: they are kept together.
    """
    if not isinstance(source, Joined) or len({part.bilateral for part in source.parts}) > 1:
        return (Store(source, grid),)
    return tuple(store for part in source.parts for store in stores_of(part, grid))


def open_stores(
    source: MemberSource, grid: Grid, progress: Progress = silent
) -> Store | JoinedStore:
    """Return the columns of a source, built first where they are missing or damaged."""
    stores = [open_store(store.source, grid, progress) for store in stores_of(source, grid)]
    return stores[0] if len(stores) == 1 else JoinedStore(tuple(stores))
