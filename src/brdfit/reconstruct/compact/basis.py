"""The leading components of what a material may be: a population, and a little beyond it.

With the log columns L_j of a population, their weights omega_j and mean, and the functions
psi_k of the local residual (`posterior.residual`) at amplitude a,

    X = [ sqrt(omega_j) (L_j - mean) | a psi_k ],     X X^T = U Lambda U^T,     B = U Lambda^1/2

is the covariance of ln f_r and its leading components: the most variance that so many functions
can hold, over cells drawn evenly from the MERL grid. In column space B = X V with V the
eigenvectors of X^T X, so that B can be asked at any direction.

It is asked once, at the cells of a grid, and interpolated from there ever after: for one item
and for a million alike, which is what makes their answers the same.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations import Population, remember
from brdfit.progress import Progress, silent
from brdfit.reconstruct.correction_basis import training_cells
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.posterior.residual import LocalResidual, Scale
from brdfit.reconstruct.result import population_record
from brdfit.table import Table

__all__ = ["BRIGHTNESS", "LeadingBasis", "leading_basis"]

BRIGHTNESS = 2.0
"""tau: standard deviation of the unknown scale, in ln f_r."""
# Raise it when the table of the same population would change.
_VERSION = 1
# Where the components are kept: as fine as the MERL grid along theta_h, where lobes are narrow.
_GRID = Grid(90, 45, 36)
_RESIDUAL = Scale(0.2, 0.3, 600)
_CHUNK = 8192
_LABEL = "leading components"


@dataclass(frozen=True, eq=False)
class LeadingBasis:
    """[mean | B] at the cells of a grid, and what population they come from."""

    rows: FloatArray
    """(m, 1 + k), float32: one row for each of `grid.cells`."""
    grid: Grid
    population: dict[str, object]
    """What identifies the population, as JSON-able values."""
    spread: FloatArray
    """(1 + k, 1 + k): mean of phi phi^T over the cells, phi = [tau | B]."""

    @property
    def size(self) -> int:
        """Number of coefficients of a channel: brightness and k directions."""
        return int(self.rows.shape[1])

    def at(self, wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (mean (n,), phi (n, 1 + k)), float64, at directions (n, 3) above the horizon.

        phi = [tau | B_1 ... B_k], the most variable first.
        """
        result = np.empty((len(wi), self.size))
        for at, index, weight in self._corners(wi, wo):
            result[at] = np.einsum("nkq,nk->nq", self.rows[index], weight)
        mean = result[:, 0].copy()
        result[:, 0] = BRIGHTNESS
        return mean, result

    def log_value(self, coefficients: FloatArray, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return ln f_r (n, c) of coefficients (1 + k, c): the table first, then the corners."""
        table = self._combined(coefficients)
        result = np.empty((len(wi), coefficients.shape[1]))
        for at, index, weight in self._corners(wi, wo):
            result[at] = np.einsum("nkc,nk->nc", table[index], weight)
        return result

    def _combined(self, coefficients: FloatArray) -> FloatArray:
        weights = np.vstack([np.zeros((1, coefficients.shape[1])), coefficients[1:]])
        table = self.rows @ weights.astype(np.float32)
        table += self.rows[:, :1] + (BRIGHTNESS * coefficients[0]).astype(np.float32)
        return np.asarray(table, dtype=np.float64)

    def _corners(
        self, wi: FloatArray, wo: FloatArray
    ) -> Iterator[tuple[slice, IntArray, FloatArray]]:
        """Yield (which directions, rows (n, 8), weights (n, 8)) of trilinear interpolation."""
        for start in range(0, len(wi), _CHUNK):
            at = slice(start, start + _CHUNK)
            corners = self.grid.corners(*half_diff_from_directions(wi[at], wo[at]))
            index, weight = self._blank.valid_corners(*corners)
            yield at, self._row_of[index], weight.astype(np.float32)

    @cached_property
    def _blank(self) -> Table:
        """An empty table, which knows the cells that exist."""
        return Table(values=np.zeros((*self.grid.shape, 1), dtype=np.float32), grid=self.grid)

    @cached_property
    def _row_of(self) -> IntArray:
        """Row of each flat cell; 0 for cells below the horizon, which nobody asks for."""
        row_of = np.zeros(self.grid.size, dtype=np.int64)
        row_of[self.grid.cells] = np.arange(self.grid.cells.size)
        return row_of

    def __getstate__(self) -> dict[str, object]:
        """Leave what is worked out again out of what travels to a worker."""
        kept = ("rows", "grid", "population", "spread")
        return {name: self.__dict__[name] for name in kept}


def leading_basis(
    population: Population,
    components: int,
    amplitude: float,
    progress: Progress = silent,
    grid: Grid = _GRID,
) -> LeadingBasis:
    """Return the `components` leading components of a population and a residual of `amplitude`.

    Built once for each population, selection and setting, and kept in the user's cache.
    """

    def build() -> dict[str, FloatArray]:
        columns = _Columns(population, amplitude)
        vectors = columns.leading(MERL_GRID, training_cells(MERL_GRID), components)
        rows = np.empty((grid.cells.size, 1 + components), dtype=np.float32)
        for start in range(0, len(rows), _CHUNK):
            progress(_LABEL, start, len(rows))
            mean, x = columns.at(grid, grid.cells[start : start + _CHUNK])
            rows[start : start + _CHUNK] = np.column_stack([mean, x @ vectors])
        progress(_LABEL, len(rows), len(rows))
        return {"rows": rows}

    selected = [list(population.selected), population.weights.tolist()]
    settings = [components, amplitude, grid.shape, _VERSION]
    key = json.dumps([population.fingerprint, selected, settings])
    rows = remember("leading-components", key, build)["rows"]
    phi = np.column_stack([np.full(len(rows), BRIGHTNESS), rows[:, 1:].astype(np.float64)])
    spread = phi.T @ phi / len(phi)
    return LeadingBasis(rows, grid, dict(population_record(population)), spread)


@dataclass(frozen=True, eq=False)
class _Columns:
    """X, and the mean of the columns, at cells of a grid."""

    population: Population
    amplitude: float

    def at(self, grid: Grid, cells: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return (mean (n,), X (n, columns))."""
        members = MemberRows.at(self.population, *grid.directions(cells))
        logs = np.concatenate(members.logs, axis=1).astype(np.float64)
        channels = len(self.population.channels)
        weights = np.tile(self.population.weights / channels, channels)
        mean = logs @ weights
        local = LocalResidual.of(_RESIDUAL).at(grid.half_diff(cells))
        spread = (logs - mean[:, None]) * np.sqrt(weights)
        return mean, np.hstack([spread, self.amplitude * local])

    def leading(self, grid: Grid, cells: IntArray, count: int) -> FloatArray:
        """Return V (columns, count), that of most variance first."""
        gram: FloatArray | float = 0.0
        for start in range(0, len(cells), _CHUNK):
            _, x = self.at(grid, cells[start : start + _CHUNK])
            gram = gram + x.T @ x
        _, vectors = np.linalg.eigh(gram)
        return np.ascontiguousarray(vectors[:, ::-1][:, :count])
