"""Principal components of a population's log columns, at any direction and on a grid.

Every channel of every member of a source is a column L_j(x) = ln max(f_r, VALUE_FLOOR), and so
is every one of its `blends`. With their mean mu and the singular vectors V of the centred
columns over cells of the MERL grid,

    L_j(x) = mu(x) + sum_k B_k(x) V_jk,      B = (L - mu) V

The components that carry almost nothing are left out. mu and B belong to the *source*; which
members a fit may lean on, and with what weight, is a matter of the rows of V alone
(`population_prior`), so that leaving a material out needs no other basis.

On a grid mu and B are worked out once and kept in the user's cache. The members themselves
are asked at single directions; for very many directions the grid is interpolated.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from brdfit.arrays import FloatArray, IntArray, frozen
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations import Population, remember
from brdfit.populations.matrix import remember_rows
from brdfit.populations.store import stored_cells
from brdfit.progress import Progress, silent
from brdfit.reconstruct.correction_basis import training_cells
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.posterior.blends import Blends
from brdfit.reconstruct.posterior.section import SECTION
from brdfit.table import Table

__all__ = ["GridComponents", "PrincipalBasis", "principal_basis"]

# Raise it when the components of the same population would change.
_VERSION = 2
# Components below this share of the largest singular value, squared, are left out: about
# 0.001 in ln f_r over all columns of the published fits.
_SMALLEST = 1e-7
_CHUNK = 8192
_LABEL = "principal components"
# Directions above which the grid is interpolated: asking every member takes longer.
_DIRECT = 30_000


@dataclass(frozen=True, eq=False)
class PrincipalBasis:
    """V and how to have mu and B: at directions, and on a grid."""

    population: Population
    """All members of the source."""
    axes: FloatArray
    """V (columns, q): column of member j, channel c at c M + j; the blends come last."""
    blends: Blends

    @property
    def size(self) -> int:
        """Number of components q."""
        return int(self.axes.shape[1])

    def column_weights(self, population: Population) -> FloatArray:
        """Return the weight of every column (columns,): 0 for those of members left out."""
        members = np.zeros(len(self.population))
        members[population.pick] = population.weights
        channels = len(population.channels)
        return self.blends.weights(np.tile(members / channels, channels))

    def at(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return [mu | B] (n, 1 + q), float32, at directions (n, 3) above the horizon."""
        if len(wi) > _DIRECT:
            return self.on_grid(MERL_GRID).interpolated(wi, wo)
        parts = [np.empty((0, 1 + self.size), dtype=np.float32)]
        for start in range(0, len(wi), _CHUNK):
            rows = slice(start, start + _CHUNK)
            parts.append(self.of_members(MemberRows.at(self.population, wi[rows], wo[rows])))
        return np.concatenate(parts)

    def of_members(self, members: MemberRows) -> FloatArray:
        """Return [mu | B] (n, 1 + q), float32, where the members are known."""
        logs = self.blends.joined(np.concatenate(members.logs, axis=1))
        mean = logs.mean(axis=1, dtype=np.float64).astype(np.float32)[:, None]
        logs -= mean
        return np.hstack([mean, logs @ self.axes.astype(np.float32)])

    def on_section(self, progress: Progress = silent) -> FloatArray:
        """Return [mu | B] (h, d, 1 + q), float32, at the nodes of `section.SECTION`."""
        found = self.on_grid(SECTION, progress)
        rings = [rows[row_of[1::2]] for rows, row_of in map(found.ring, range(SECTION.n_theta_h))]
        return np.stack(rings)

    def on_grid(self, grid: Grid, progress: Progress = silent) -> GridComponents:
        """Return mu and B at the cells of a grid, built on first use."""
        bilateral = self.population.source.bilateral
        cells, _ = stored_cells(grid, bilateral)
        key = json.dumps([self.population.fingerprint, grid.shape, self.size, _VERSION])

        def blocks() -> Iterator[FloatArray]:
            for start in range(0, cells.size, _CHUNK):
                progress(_LABEL, start, cells.size)
                directions = grid.directions(cells[start : start + _CHUNK])
                yield self.of_members(MemberRows.at(self.population, *directions))
            progress(_LABEL, cells.size, cells.size)

        rows = remember_rows("principal", key, (cells.size, 1 + self.size), blocks)
        return GridComponents(grid, bilateral, rows)


@dataclass(frozen=True, eq=False)
class GridComponents:
    """[mu | B] at the cells of a grid."""

    grid: Grid
    bilateral: bool
    """Whether phi_d and pi - phi_d have one row."""
    rows: FloatArray
    """(m, 1 + q), float32, on disk."""

    def ring(self, i: int) -> tuple[FloatArray, IntArray]:
        """Return (the rows of theta_h[i], which of them each of its cells has (d * phi,)).

        Cells below the horizon have the first.
        """
        first, within = _rings(self.grid, self.bilateral)
        return self.rows[first[i] : first[i + 1]], within[i]

    def interpolated(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return [mu | B] (n, 1 + q), trilinear between valid cells."""
        blank = Table(values=np.zeros((*self.grid.shape, 1), dtype=np.float32), grid=self.grid)
        first, within = _rings(self.grid, self.bilateral)
        row_of = (first[:-1, None] + within).reshape(-1)
        result = np.empty((len(wi), self.rows.shape[1]), dtype=np.float32)
        for start in range(0, len(wi), _CHUNK):
            at = slice(start, start + _CHUNK)
            corners = self.grid.corners(*half_diff_from_directions(wi[at], wo[at]))
            index, weight = blank.valid_corners(*corners)
            gathered = self.rows[row_of[index]]
            result[at] = np.einsum("nkq,nk->nq", gathered, weight.astype(np.float32))
        return result


@lru_cache(maxsize=8)
def _rings(grid: Grid, bilateral: bool) -> tuple[IntArray, IntArray]:
    """Return (first row of each theta_h (h + 1,), which of its rows each cell has (h, d * phi)).

    A cell below the horizon has the first row of its theta_h: there always is one, at theta_d 0.
    """
    cells, expand = stored_cells(grid, bilateral)
    ring = grid.size // grid.n_theta_h
    first = np.searchsorted(cells, np.arange(grid.n_theta_h + 1) * ring)
    within = np.zeros(grid.size, dtype=np.int64)
    within[grid.cells] = expand - first[grid.cells // ring]
    return frozen(first), frozen(within.reshape(-1, ring))


def principal_basis(population: Population, progress: Progress = silent) -> PrincipalBasis:
    """Return the principal basis of a population's source, computed once and kept."""
    everyone = Population.of(population.source)

    def build() -> dict[str, FloatArray | IntArray]:
        progress(_LABEL, 0, 1)
        members = MemberRows.at(everyone, *MERL_GRID.directions(training_cells(MERL_GRID)))
        logs = np.concatenate(members.logs, axis=1)
        blends = Blends.of(logs)
        axes = axes_of(blends.joined(logs))
        return {"axes": axes, "pairs": blends.pairs, "shifts": blends.shifts}

    key = f"{everyone.fingerprint} {_SMALLEST!r} {_VERSION}"
    found = remember("posterior-axes", key, build)
    return PrincipalBasis(everyone, found["axes"], Blends(found["pairs"], found["shifts"]))


def axes_of(logs: FloatArray, smallest: float = _SMALLEST) -> FloatArray:
    """Return V (columns, q) of log columns (cells, columns), largest component first."""
    centred = logs.astype(np.float64)
    centred -= centred.mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(centred.T @ centred)
    kept = values > smallest * values[-1]
    return np.ascontiguousarray(vectors[:, kept][:, ::-1])
