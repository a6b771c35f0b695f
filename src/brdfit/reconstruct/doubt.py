"""What a model states of its own doubt, at coarse nodes: quick to ask anywhere, small to keep.

A method that knows how sure it is answers some ten thousand directions a second; a table has a
million cells. Both deviations of ln f_r, that of the result and that of the prior, vary slowly:
30 x 30 x 12 nodes (6 degrees at most in theta_h, 3 in theta_d, 15 in phi_d) hold them, trilinear
between.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct.trust import KnowsItsPrior
from brdfit.table import Table

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Model, Reconstruction

__all__ = ["NODES", "Doubt", "stated_doubt", "table_at_nodes"]

NODES = Grid(30, 30, 12)
_CHUNK = 2_000


@dataclass(frozen=True, eq=False)
class Doubt:
    """Deviations of ln f_r at `NODES`; answers as a model that knows its prior does."""

    stated: Table
    """Of the result: one channel for all, or one each."""
    prior: Table
    """Before any sample, the brightness known: one channel."""
    noise: float
    """Standard deviation of ln f_r of a good sample."""

    @classmethod
    def of(cls, model: Model, stated: Table | None) -> Doubt | None:
        """Return that of a model with its `stated_doubt`; None if it does not know its prior."""
        if stated is None or not isinstance(model, KnowsItsPrior):
            return None
        prior = model.prior_stddev(*NODES.directions(NODES.cells))
        return cls(stated, table_at_nodes(prior[:, None], ("all",)), float(model.noise))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return the standard deviation of ln f_r (n, channels or 1)."""
        return self.stated.evaluate(wi, wo)

    def prior_stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return that before any sample, (n,)."""
        return self.prior.evaluate(wi, wo)[:, 0]


def stated_doubt(result: Reconstruction, progress: Progress = silent) -> Table | None:
    """Return the standard deviation of ln f_r at `NODES`; None for a method that states none.

    One channel, "all", where the method does not tell channels apart.
    """
    wi, wo = NODES.directions(NODES.cells)
    if result.model.stddev(wi[:1], wo[:1]) is None:
        return None
    parts = []
    progress("uncertainty", 0, len(wi))
    for first in range(0, len(wi), _CHUNK):
        rows = slice(first, first + _CHUNK)
        parts.append(result.stddev(wi[rows], wo[rows]))
        progress("uncertainty", min(first + _CHUNK, len(wi)), len(wi))
    found, channels = np.concatenate(parts), result.samples.channels
    if np.allclose(found, found[:, :1], rtol=1e-6):
        found, channels = found[:, :1], ("all",)
    return table_at_nodes(found, channels)


def table_at_nodes(at_cells: FloatArray, channels: tuple[str, ...]) -> Table:
    """Return values (cells, channels) of the cells of `NODES` as a table."""
    values = np.full((NODES.size, at_cells.shape[1]), np.nan)
    values[NODES.cells] = at_cells
    return Table(values=values.reshape(*NODES.shape, -1), grid=NODES, channels=channels)
