"""The leading components of what a material may be: a population, and a little beyond it.

With the log columns L_j of a population, their weights omega_j and mean, and the functions
psi_k of the local residual (`compact.residual`) at amplitude a,

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
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.linalg import side_by_side, thin_product
from brdfit.populations import Population, remember
from brdfit.populations.store import stored_cells
from brdfit.progress import Progress, silent
from brdfit.reconstruct.compact.corners import Carriage, Corners, interpolated
from brdfit.reconstruct.compact.residual import LocalResidual, Scale
from brdfit.reconstruct.correction_basis import training_cells
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.posterior.prior import BRIGHTNESS
from brdfit.reconstruct.result import population_record
from brdfit.reconstruct.slabs import Put

__all__ = ["LeadingBasis", "leading_basis"]

# Raise it when the table of the same population would change.
_VERSION = 2
# Where the components are kept: as fine as the MERL grid along theta_h, where lobes are narrow.
_GRID = Grid(90, 45, 36)
_RESIDUAL = Scale(0.2, 0.3, 600)
_CHUNK = 8192
_LABEL = "leading components"


@dataclass(frozen=True, eq=False)
class LeadingBasis:
    """[mean | B] at the cells of a grid, and what population they come from."""

    rows: FloatArray = field(repr=False)
    """(m, 1 + k), float32: one row for each of `grid.cells`."""
    grid: Grid
    population: dict[str, object]
    """What identifies the population, as JSON-able values."""

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
            result[at] = interpolated(self.rows, index, weight)
        mean = result[:, 0].copy()
        result[:, 0] = BRIGHTNESS
        return mean, result

    def log_value(self, coefficients: FloatArray, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return ln f_r (n, c) of coefficients (1 + k, c): the table first, then the corners."""
        combined, brightness = self._combined(coefficients)
        table = combined.astype(np.float64) + brightness
        result = np.empty((len(wi), coefficients.shape[1]))
        for at, index, weight in self._corners(wi, wo):
            result[at] = interpolated(table, index, weight)
        return result

    def on_grid(self, coefficients: FloatArray, grid: Grid) -> Put:
        """Return what puts f_r at the cells of a grid."""
        return Carriage.between(self.grid, grid).of(*self._combined(coefficients))

    def _combined(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (mean + phi z without its brightness (m + 1, c), float32, brightness (c,)).

        The last row is 0.
        """
        weights = np.vstack([np.ones((1, coefficients.shape[1])), coefficients[1:]])
        weights = weights.astype(np.float32)
        table = np.empty((len(self.rows) + 1, weights.shape[1]), dtype=np.float32)
        table[-1] = 0.0

        def combine(number: int) -> None:
            start = number * _CHUNK
            rows = self.rows[start : start + _CHUNK]
            table[start : start + len(rows)] = thin_product(rows, weights)

        side_by_side(combine, -(-len(self.rows) // _CHUNK))
        return table, BRIGHTNESS * coefficients[0]

    def _corners(
        self, wi: FloatArray, wo: FloatArray
    ) -> Iterator[tuple[slice, IntArray, FloatArray]]:
        """Yield (which directions, rows (n, 8), weights (n, 8)) of trilinear interpolation."""
        for start in range(0, len(wi), _CHUNK):
            at = slice(start, start + _CHUNK)
            yield at, *Corners.of(self.grid).at(*half_diff_from_directions(wi[at], wo[at]))

    @cached_property
    def spread(self) -> FloatArray:
        """(1 + k, 1 + k): mean of phi phi^T over evenly drawn pairs of directions."""
        total = np.zeros((self.size, self.size))
        share = self.grid.solid_angle.reshape(-1)[self.grid.cells]
        for start in range(0, len(self.rows), _CHUNK):
            at = slice(start, start + _CHUNK)
            phi = self.rows[at].astype(np.float64)
            phi[:, 0] = BRIGHTNESS
            total += phi.T @ (share[at, None] * phi)
        return total

    def __getstate__(self) -> dict[str, object]:
        """Leave what is worked out again out of what travels to a worker."""
        kept = ("rows", "grid", "population")
        return {name: self.__dict__[name] for name in kept}


def leading_basis(
    population: Population,
    components: int,
    amplitude: float,
    progress: Progress = silent,
    grid: Grid | None = None,
) -> LeadingBasis:
    """Return the `components` leading components of a population and a residual of `amplitude`.

    Built once for each population, selection and setting, and kept in the user's cache.
    """
    grid = _GRID if grid is None else grid

    def build() -> dict[str, FloatArray]:
        columns = _Columns(population, amplitude)
        vectors = columns.leading(MERL_GRID, training_cells(MERL_GRID), components)
        return {"rows": columns.combined(grid, vectors, progress)}

    selected = [list(population.selected), population.weights.tolist()]
    settings = [components, amplitude, grid.shape, _VERSION]
    key = json.dumps([population.fingerprint, selected, settings])
    rows = remember("leading-components", key, build)["rows"]
    return LeadingBasis(rows, grid, dict(population_record(population)))


@dataclass(frozen=True, eq=False)
class _Columns:
    """The columns of X at cells of a grid: members, then functions of the residual."""

    population: Population
    amplitude: float

    def leading(self, grid: Grid, cells: IntArray, count: int) -> FloatArray:
        """Return V (columns, count), that of most variance first."""
        gram: FloatArray | float = 0.0
        for start in range(0, len(cells), _CHUNK):
            at = cells[start : start + _CHUNK]
            x = np.hstack([self._members(grid, at)[1], self._local(grid, at)])
            gram = gram + x.T @ x
        _, vectors = np.linalg.eigh(gram)
        return np.ascontiguousarray(vectors[:, ::-1][:, :count])

    def combined(self, grid: Grid, vectors: FloatArray, progress: Progress) -> FloatArray:
        """Return [mean | X V] (cells, 1 + count), float32, at the cells of a grid.

        Where the population tells no phi_d from pi - phi_d, its members are asked at one of
        the two.
        """
        cells, expand = stored_cells(grid, self.population.source.bilateral)
        columns = len(vectors) - LocalResidual.of(_RESIDUAL).size
        of_members, of_local = vectors[:columns].astype(np.float32), vectors[columns:]
        stored = np.empty((len(cells), 1 + vectors.shape[1]), dtype=np.float32)
        for start in range(0, len(stored), _CHUNK):
            progress(_LABEL, start, len(stored))
            mean, x = self._members(grid, cells[start : start + _CHUNK])
            at = slice(start, start + _CHUNK)
            stored[at] = np.column_stack([mean, x.astype(np.float32) @ of_members])
        rows = stored[expand]
        for start in range(0, len(rows), _CHUNK):
            at = slice(start, start + _CHUNK)
            rows[at, 1:] += self._local(grid, grid.cells[at]) @ of_local
        progress(_LABEL, len(stored), len(stored))
        return rows

    def _members(self, grid: Grid, cells: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return (mean (n,), weighted deviations of the columns (n, columns))."""
        members = MemberRows.at(self.population, *grid.directions(cells))
        logs = np.concatenate(members.logs, axis=1).astype(np.float64)
        channels = len(self.population.channels)
        weights = np.tile(self.population.weights / channels, channels)
        mean = logs @ weights
        logs -= mean[:, None]
        logs *= np.sqrt(weights)
        return mean, logs

    def _local(self, grid: Grid, cells: IntArray) -> FloatArray:
        """Return a psi (n, size)."""
        return self.amplitude * LocalResidual.of(_RESIDUAL).at(grid.half_diff(cells))
