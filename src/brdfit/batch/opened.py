"""A finished (or half finished) batch, read on demand: one item is a BRDF like any other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, as_unit_directions
from brdfit.batch.record import FAILED, words
from brdfit.batch.store import BatchStore
from brdfit.errors import FitError, UsageError
from brdfit.geometry import split_by_horizon
from brdfit.grid import MERL_GRID, Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct import Outcome
from brdfit.reconstruct.compact import CompactModel, LeadingBasis
from brdfit.samples import Source
from brdfit.table import Table

__all__ = ["Batch", "BatchItem", "open_batch"]


def open_batch(path: str | Path) -> Batch:
    """Return the batch that `brdfit batch` wrote at `path`, finished or not.

    Raises `UsageError` where there is none, `MissingExtra` without zarr.
    """
    return Batch(BatchStore.open(Path(path)))


class Batch:
    """Items by number or name; nothing is read before it is asked for."""

    def __init__(self, store: BatchStore) -> None:
        self._store = store

    def __len__(self) -> int:
        return self._store.count

    def __repr__(self) -> str:
        return f"Batch({self.path.name!r}, {len(self)} items, {self.done} done)"

    @property
    def path(self) -> Path:
        """Folder of the store."""
        return self._store.path

    @property
    def attributes(self) -> dict[str, Any]:
        """Input, method, population and versions, as JSON-able values."""
        return self._store.attributes

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names of every item."""
        return tuple(self.attributes["channels"])

    @property
    def done(self) -> int:
        """Number of items that are done."""
        missing = (self._store.rows(block) for block in self._store.missing())
        return len(self) - sum(stop - start for start, stop in missing)

    def column(self, name: str) -> np.ndarray:
        """Return one array of the store for all items: noise, outlier_share, deviation, ..."""
        return np.asarray(self._store.group[name][:])

    def rows(self, name: str, start: int, stop: int) -> np.ndarray:
        """Return one array of the store for the items from `start` to `stop`."""
        return np.asarray(self._store.group[name][start:stop])

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Name of every item; empty for one that is not done."""
        return tuple(words(row) for row in self.column("name"))

    @cached_property
    def basis(self) -> LeadingBasis:
        """What the coefficients multiply."""
        rows = np.asarray(self._store.group["basis"][:])
        return LeadingBasis(rows, Grid(*self.attributes["grid"]), self.attributes["population"])

    def __getitem__(self, key: int | str) -> BatchItem:
        """Return an item by number (from 0) or name.

        Raises `UsageError` where there is no such item, `FitError` for one without a result.
        """
        index = self._number(key)
        outcome = int(self._store.group["outcome"][index])
        name = words(np.asarray(self._store.group["name"][index]))
        if outcome == 0:
            raise FitError(f"{self.path.name}: item {key!r} is not done; repeat brdfit batch.")
        if outcome == FAILED:
            message = words(np.asarray(self._store.group["message"][index]))
            raise FitError(f"{self.path.name}: item {name!r} could not be fitted: {message}.")
        z = np.asarray(self._store.group["coefficients"][index], dtype=np.float64)
        ended = Outcome(self.attributes["outcomes"][str(outcome)])
        return BatchItem(self, index, name, ended, CompactModel(self.basis, z.T))

    def __iter__(self) -> Iterator[BatchItem]:
        """Yield the items that have a result, in order."""
        for index in np.flatnonzero(~np.isin(self.column("outcome"), (0, FAILED))):
            yield self[int(index)]

    def _number(self, key: int | str) -> int:
        if isinstance(key, str):
            if key in self._numbers:
                return self._numbers[key]
            if not key.lstrip("-").isdigit():
                raise UsageError(f"{self.path.name}: there is no item {key!r}.{self._near(key)}")
            key = int(key)
        if not -len(self) <= key < len(self):
            raise UsageError(
                f"{self.path.name}: item {key} was asked for but there are {len(self)}."
            )
        return key % len(self)

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {name: index for index, name in enumerate(self.names) if name}

    def _near(self, key: str) -> str:
        from difflib import get_close_matches

        near = get_close_matches(key, self._numbers, n=1)
        return f" Did you mean {near[0]!r}?" if near else ""


@dataclass(frozen=True, eq=False)
class BatchItem:
    """One item: a function of direction, and how its fit ended."""

    batch: Batch
    index: int
    name: str
    outcome: Outcome
    model: CompactModel

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels), 1/sr, at direction pairs (n, 3).

        0 below the horizon, NaN where a direction is not finite.
        """
        wi, wo = as_unit_directions("wi", wi), as_unit_directions("wo", wo)
        finite, above = split_by_horizon(wi, wo)
        result = np.full((len(above), len(self.batch.channels)), np.nan)
        result[finite] = 0.0
        if above.any():
            result[above] = self.model.evaluate(wi[above], wo[above])
        return result

    def table(self, grid: Grid = MERL_GRID, progress: Progress = silent) -> Table:
        """Return the dense result on `grid`."""
        values, finite = self.model.seen_dense(grid, progress)
        values.flags.writeable = False  # handed over: the table need not copy it
        bands = self.batch.attributes["wavelengths"]
        return Table(
            values=values,
            known_finite=finite,
            grid=grid,
            wavelengths=np.array(bands) if bands else None,
            channels=self.batch.channels,
            source=Source(
                name=self.name,
                format="batch",
                sha256=self.batch.attributes["input"]["sha256"],
                convention="f_r in 1/sr, cosine not included",
                notes=(f"item {self.index} of {self.batch.path.name}", self.outcome.value),
            ),
        )
