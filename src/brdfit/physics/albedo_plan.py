"""The directional albedo of tables on one grid as a sparse product.

Interpolation and integral are linear in the values: albedo = operator @ values. The operator
depends on the grid, on which cells are valid, and on the angles; it is worked out once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from brdfit.albedo import RINGS, SPOKES, albedo_rule, checked_incidence
from brdfit.arrays import BoolArray, FloatArray, IntArray, frozen
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.table import Table

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["AlbedoPlan"]


@dataclass(frozen=True, eq=False)
class AlbedoPlan:
    """Angles of incidence, a grid and its valid cells, worked out into one operator.

    | name       | shape           | unit and range                                          |
    |------------|-----------------|---------------------------------------------------------|
    | `theta_i`  | (angles,)       | radians                                                 |
    | `cells`    | (m,)            | flat indices of the cells that count, ascending         |
    | `operator` | (angles, m)     | sparse; times f_r at `cells` is the directional albedo  |
    """

    theta_i: FloatArray
    grid: Grid
    cells: IntArray
    operator: csr_array

    @classmethod
    def build(cls, grid: Grid, valid: BoolArray, theta_i: npt.ArrayLike) -> AlbedoPlan:
        """Return the plan for tables on `grid` with these `valid` cells at `theta_i` (angles,).

        Invalid cells are answered for as `Table.evaluate` does: by their valid neighbours.
        """
        from scipy.sparse import csr_array, vstack

        angles = checked_incidence(theta_i)
        blank = Table(values=np.zeros(grid.shape, dtype=np.float32), grid=grid, valid=valid)
        rows = []
        for angle in angles:
            wi, wo, weight = albedo_rule(float(angle), RINGS, SPOKES)
            corners = grid.corners(*half_diff_from_directions(wi, wo))
            index, share = blank.valid_corners(*corners)
            amount = (share * weight[:, None]).ravel()
            column = index.ravel()
            row = np.zeros(column.size, dtype=np.int64)
            rows.append(csr_array((amount, (row, column)), shape=(1, grid.size)))
        whole = vstack(rows, format="csr")
        cells, column = np.unique(whole.indices, return_inverse=True)
        operator = csr_array((whole.data, column, whole.indptr), shape=(len(angles), cells.size))
        return cls(frozen(angles), grid, frozen(cells.astype(np.int64)), operator)

    def albedo(self, values: FloatArray) -> FloatArray:
        """Return the directional albedo (angles, channels) of f_r (m, channels) at `cells`."""
        return np.asarray(self.operator @ values)

    def of(self, table: Table) -> FloatArray:
        """Return the directional albedo (angles, channels) of a table on the plan's grid."""
        flat = table.values.reshape(self.grid.size, -1)[self.cells]
        return self.albedo(flat.astype(np.float64))
