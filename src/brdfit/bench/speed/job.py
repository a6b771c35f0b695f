"""What the stages work on: measurements made by the program, their sizes, and a folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.bench.outliers import contaminate
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations import Population, population
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Job", "Sizes"]

_NOISE = 0.02
_OUTLIERS = 0.2
# Directions that the items with directions of their own draw from.
_POOL = 1024
_FIRST_BAND, _LAST_BAND = 400.0, 700.0


@dataclass(frozen=True)
class Sizes:
    """How much work a stage is given."""

    few: int = 1000
    """RGB samples of a small measurement."""
    bands: int = 31
    """Spectral channels."""
    band_samples: int = 1439
    """Samples of a spectral measurement."""
    many: int = 110_000
    """RGB samples of a large measurement, 10 % of the grid."""
    items: int = 4096
    """Items of a batch."""
    per_item: int = 64
    """RGB samples of an item."""
    picture: int = 256
    """Edge of a preview, pixels."""
    grid: Grid = field(default=MERL_GRID)
    """Of dense tables."""


@dataclass(frozen=True, eq=False)
class Job:
    """Measurements of a material that the fits do not lean on: its first, alphabetically."""

    lean_on: str | Population
    """Population that is leaned on, and that the measurements are made from."""
    seed: int
    sizes: Sizes
    folder: Path
    """Where files are written and read."""
    measured: tuple[tuple[str, Path, dict[str, Any]], ...] = ()
    """Real files to read: laboratory, path, options of the reader."""

    @cached_property
    def everything(self) -> Population:
        """The population with the measured material."""
        return population(self.lean_on)

    @cached_property
    def material(self) -> str:
        """Name of the measured material."""
        return self.everything.unique_materials[0]

    @cached_property
    def others(self) -> Population:
        """The population without the measured material."""
        return self.everything.without([self.material])

    def truth(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, 3) of the measured material at directions (n, 3)."""
        found = self.everything.subset([self.material]).evaluate(wi, wo)[:, 0]
        return np.maximum(found.astype(np.float64), 1e-4)

    def samples(self, count: int) -> Samples:
        """Return RGB samples at `count` cells, 2 % noise, a fifth spoilt by `factor` outliers."""
        rng = np.random.default_rng([self.seed, count])
        cells = self._cells(count, rng)
        wi, wo = self.sizes.grid.directions(cells)
        return Samples(wi=wi, wo=wo, value=_measured(self.truth(wi, wo), rng))

    def spectral(self) -> Samples:
        """Return samples in many bands: the colours of the material, blended along them."""
        sizes = self.sizes
        rng = np.random.default_rng([self.seed, sizes.band_samples, sizes.bands])
        cells = self._cells(sizes.band_samples, rng)
        wi, wo = sizes.grid.directions(cells)
        bands = np.linspace(_FIRST_BAND, _LAST_BAND, sizes.bands)
        share = np.stack([np.interp(bands, (450.0, 550.0, 650.0), unit) for unit in np.eye(3)])
        value = self.truth(wi, wo)[:, ::-1] @ share
        return Samples(wi=wi, wo=wo, value=_measured(value, rng), wavelengths=bands)

    def items(self, shared: bool) -> list[Samples]:
        """Return the items of a batch: blends of two materials, a fifth of the samples spoilt.

        All at the same directions if `shared`, else each at directions of its own.
        """
        sizes = self.sizes
        rng = np.random.default_rng([self.seed, sizes.items, int(shared)])
        pool = sizes.per_item if shared else max(_POOL, sizes.per_item)
        cells = self._cells(min(pool, sizes.grid.cells.size), rng)
        wi, wo = sizes.grid.directions(cells)
        logs = self.everything.log_values(wi, wo)
        found = []
        for _ in range(sizes.items):
            rows = np.arange(sizes.per_item)
            if not shared:
                rows = rng.choice(len(cells), sizes.per_item, replace=False)
            one, other = rng.integers(logs.shape[1], size=2)
            share = rng.uniform()
            blend = np.exp(share * logs[rows, one] + (1.0 - share) * logs[rows, other])
            found.append(Samples(wi=wi[rows], wo=wo[rows], value=_measured(blend, rng)))
        return found

    def table(self, grid: Grid) -> Table:
        """Return the measured material itself on a grid."""
        values = np.zeros((*grid.shape, 3), dtype=np.float32)
        values.reshape(-1, 3)[grid.cells] = self.truth(*grid.directions(grid.cells))
        return Table(values=values, grid=grid)

    def directions(self, count: int) -> tuple[FloatArray, FloatArray]:
        """Return (wi, wo), each (count, 3), of the first cells of the grid."""
        return self.sizes.grid.directions(self.sizes.grid.cells[:count])

    def _cells(self, count: int, rng: np.random.Generator) -> IntArray:
        cells = self.sizes.grid.cells
        return np.asarray(cells[np.sort(rng.choice(cells.size, count, replace=False))])


def _measured(truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    noisy = truth.astype(np.float64) * np.exp(rng.normal(0.0, _NOISE, truth.shape))
    return contaminate("factor", noisy, _OUTLIERS, rng).values
