"""Some of a file's many values: drawn at random, the same ones for the same seed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import IntArray
from brdfit.errors import UsageError
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Draw", "samples_of_cells"]


@dataclass(frozen=True)
class Draw:
    """How many are wanted, and the seed that decides which."""

    count: int | None = None
    """None = all."""
    seed: int = 0

    def of(self, n: int, found: str) -> IntArray:
        """Return ascending indices below `n`, none twice.

        Raises `UsageError` where `count` is no number from 1 to `n`; `found` is its beginning.
        """
        if self.count is None:
            return np.arange(n)
        whole = isinstance(self.count, int) and not isinstance(self.count, bool)
        if not whole or not 1 <= self.count <= n:
            raise UsageError(
                f"{found} to draw from, but count is {self.count!r}; give a number from 1 to {n:,}."
            )
        return np.sort(np.random.default_rng(self.seed).choice(n, self.count, replace=False))

    def notes(self, n: int, what: str) -> tuple[str, ...]:
        """Return what is to be said of the choice among `n`: nothing where all were taken."""
        if self.count is None:
            return ()
        return (f"{self.count:,} of {n:,} {what}, drawn with seed {self.seed}",)


def samples_of_cells(table: Table, draw: Draw) -> Samples:
    """Return the valid cells of a table as samples at the directions of their nodes.

    `rows` are 1-based cell numbers in the order of the grid.
    """
    cells = np.flatnonzero(table.mask)
    source = table.source
    chosen = draw.of(cells.size, f"{source.name}: the file has {cells.size:,} valid cells")
    notes = (*source.notes, *draw.notes(cells.size, "valid cells"))
    cells = cells[chosen]
    wi, wo = table.grid.directions(cells)
    return Samples(
        wi=wi,
        wo=wo,
        value=table.values.reshape(-1, table.n_channels)[cells],
        wavelengths=table.wavelengths,
        channels=table.channels,
        rows=cells + 1,
        source=replace(source, notes=notes),
    )
