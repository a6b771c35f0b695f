"""Trilinear interpolation between the cells of a grid that are above the horizon.

Of the eight cells around a point those below the horizon have no say, the weights of the others
sum to 1. At the cells of another grid the weights are products along the three axes,

    sum_k w_k m_k T_k / sum_k w_k m_k,      m = 1 above the horizon, 0 below

so that sums above and below are three small products each, and that below is the same for
every table. Where hardly any weight is left the corners are asked one by one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.grid import Grid
from brdfit.reconstruct.slab_cells import HIGHEST, LOWEST, Between, Lines, put_lines
from brdfit.reconstruct.slabs import Carried, Put, along_theta_h, highest
from brdfit.table import Table

__all__ = ["Carriage", "Corners", "interpolated"]

# Directions whose corners are gathered at once: what is gathered stays in the processor's cache.
_GATHERED = 256
# Weight above the horizon below which a quotient of sums is not to be trusted.
_HARDLY = 1e-3
# Of weights along an axis; what is finer is rounding.
_DECIMALS = 8


@dataclass(frozen=True, eq=False)
class Corners:
    """The cells around any point, as rows of `grid.cells`."""

    grid: Grid

    @staticmethod
    @lru_cache(maxsize=8)
    def of(grid: Grid) -> Corners:
        """Return those of a grid, made once."""
        return Corners(grid)

    def at(
        self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return (rows (n, 8), weights (n, 8) float32) of points above the horizon."""
        index, weight = self._blank.valid_corners(*self.grid.corners(theta_h, theta_d, phi_d))
        return self._row_of[index], weight.astype(np.float32)

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


def interpolated(rows: FloatArray, index: IntArray, weight: FloatArray) -> FloatArray:
    """Return sums (n, q) of rows (m, q) at index (n, 8), with weights (n, 8)."""
    result = np.empty((len(index), rows.shape[1]), np.result_type(rows, weight))
    for start in range(0, len(index), _GATHERED):
        at = slice(start, start + _GATHERED)
        np.einsum("nkq,nk->nq", rows.take(index[at], axis=0), weight[at], out=result[at])
    return result


@dataclass(frozen=True, eq=False)
class Carriage:
    """What carries any table at the cells of a grid to those of another."""

    grid: Grid
    row_of: IntArray
    """(grid.size,) row of each flat cell, and the row after the last of those below the horizon."""
    to_h: FloatArray
    """(h, nodes), float32"""
    lines: Lines
    """Their scale is one over the weight above the horizon; 0 for the odd cells."""
    kind: IntArray
    """(h, d), int32: of each line"""
    odd: IntArray
    """Flat cells that hardly have any, ascending."""
    first: IntArray
    """(h + 1,): those of theta_h[i] are from first[i] to first[i + 1]."""
    index: IntArray
    """(odd, 8) rows around each of them..."""
    weight: FloatArray
    """(odd, 8) ...and their weights."""

    @staticmethod
    @lru_cache(maxsize=4)
    def between(grid: Grid, other: Grid) -> Carriage:
        """Return what carries from one grid to another, made once."""
        # Where nodes coincide their weights are 1 and 0, not nearly so.
        h, d, phi = (np.round(matrix, _DECIMALS) for matrix in grid.linear(other))
        carried = Carried.of(grid.above_horizon[:, None].astype(np.float64), h, d, phi)
        total = np.stack([carried.at(i)[0] for i in range(other.n_theta_h)])
        hardly = total < _HARDLY
        odd = np.flatnonzero(hardly & other.above_horizon)
        scale = np.divide(1.0, total, out=np.zeros_like(total), where=~hardly)
        lines = np.stack([scale, highest(other).reshape(other.shape)], axis=2, dtype=np.float32)
        kinds, kind = np.unique(lines.reshape(-1, 2, other.n_phi_d), axis=0, return_inverse=True)
        ring = other.n_theta_d * other.n_phi_d
        row_of = np.full(grid.size, grid.cells.size)
        row_of[grid.cells] = np.arange(grid.cells.size)
        return Carriage(
            grid,
            row_of,
            h.astype(np.float32),
            Lines(Between.of(d), Between.of(phi), kinds[:, 0], kinds[:, 1]),
            kind.reshape(other.shape[:2]).astype(np.int32),
            odd,
            np.searchsorted(odd, np.arange(other.n_theta_h + 1) * ring),
            *Corners.of(grid).at(*other.half_diff(odd)),
        )

    def of(self, table: FloatArray, constant: FloatArray) -> Put:
        """Return what puts the exponentials of values at the cells of the other grid.

        The values are those of a table (cells + 1, c), float32, whose last row is 0, and a
        constant (c,).
        """
        nodes_at, lines = self._nodes(table), self.lines.each(table.shape[1])
        shift = np.tile(constant.astype(np.float32), self.lines.scale.shape[1])

        def put(rings: slice, cells: FloatArray) -> None:
            kind = self.kind[rings]
            in_lines = cells.reshape(*kind.shape, -1)
            put_lines(nodes_at(rings), lines, kind, shift, in_lines)
            odd = slice(self.first[rings.start], self.first[rings.stop])
            if odd.start < odd.stop:
                ring, cell = np.divmod(self.odd[odd], cells.shape[1])
                alone = interpolated(table, self.index[odd], self.weight[odd]) + constant
                cells[ring - rings.start, cell] = np.exp(np.clip(alone, LOWEST, HIGHEST))

        return put

    def _nodes(self, table: FloatArray) -> Callable[[slice], FloatArray]:
        """Return what gives a table (rings, d nodes, phi nodes * c) at the other theta_h."""
        of_ring = self.row_of.reshape(self.grid.n_theta_h, -1)

        def at_own(rings: slice) -> FloatArray:
            nodes = table.take(of_ring[rings], axis=0, mode="clip")
            return nodes.reshape(len(nodes), self.grid.n_theta_d, -1)

        if len(self.to_h) == len(of_ring) and np.array_equal(self.to_h, np.eye(len(of_ring))):
            return at_own
        return along_theta_h(at_own(slice(None)), self.to_h).__getitem__
