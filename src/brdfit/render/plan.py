"""The sphere image of a table as a sparse product, for shading thousands of tables.

Interpolation, light and cosine are all linear in the values: image = operator @ values.
`SpherePlan` works that operator out once for a grid and touches only the cells that the
image looks at, so whoever computes a table cell by cell need compute no others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brdfit.arrays import FloatArray, IntArray, frozen
from brdfit.errors import UsageError
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.render.illumination import Illumination
from brdfit.render.sphere import Queries, Sphere, in_channels
from brdfit.table import Table

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["SpherePlan"]


@dataclass(frozen=True, eq=False)
class SpherePlan:
    """A sphere, an illumination and a grid, worked out into sparse operators.

    `cells` (m,) are the flat indices of the grid's cells that the image looks at,
    ascending. `colour` holds one operator (pixels, m) for each of R, G, B; `grey` one for
    the light's luminance.
    """

    sphere: Sphere
    illumination: Illumination
    grid: Grid
    cells: IntArray
    colour: tuple[csr_array, csr_array, csr_array]
    grey: csr_array

    @classmethod
    def build(
        cls, sphere: Sphere, illumination: Illumination, grid: Grid = MERL_GRID
    ) -> SpherePlan:
        """Return the plan for tables on `grid` in which every cell above the horizon is valid.

        Raises `UsageError` for an illumination with a surround: the plan knows lights only.
        """
        if any(illumination.surround):
            raise UsageError(
                f"SpherePlan: illumination {illumination.name!r} has a surround but a plan holds "
                f"directional lights only. Use Sphere.shade, or an illumination without one."
            )
        queries = sphere.directions(illumination)
        # The table is only asked which cells answer; its values are never looked at.
        blank = Table(values=np.zeros(grid.shape, dtype=np.float32), grid=grid)
        corners = grid.corners(*half_diff_from_directions(queries.wi, queries.wo))
        index, weight = blank.valid_corners(*corners)
        used = np.zeros(grid.size, dtype=bool)
        used[index[weight > 0.0]] = True
        cells = np.flatnonzero(used)
        column = np.searchsorted(cells, index)
        # A corner of weight zero may be any cell: point it at one that exists.
        column[weight <= 0.0] = 0
        n = len(sphere.normal)
        amounts = np.hstack([illumination.irradiance, in_channels(illumination.irradiance, 1)])
        red, green, blue, grey = (
            _operator(queries, column, weight, amount, (n, cells.size)) for amount in amounts.T
        )
        return cls(sphere, illumination, grid, frozen(cells), (red, green, blue), grey)

    def shade(self, values: FloatArray) -> FloatArray:
        """Return the linear image (size, size, channels) of f_r (m, channels) at `cells`."""
        return self.sphere.image(self.disk(values))

    def disk(self, values: FloatArray) -> FloatArray:
        """Return the pixels of the disk (pixels, channels) of f_r (m, channels) at `cells`."""
        values = values[:, None] if values.ndim == 1 else values
        if len(values) != self.cells.size:
            raise UsageError(
                f"SpherePlan: found values of shape {values.shape} but the plan looks at "
                f"{self.cells.size} cells; give one row for each of plan.cells."
            )
        channels = values.shape[1]
        operators = self.colour if channels == 3 else (self.grey,) * channels
        columns = [operator @ values[:, c] for c, operator in enumerate(operators)]
        return np.stack(columns, axis=1)


def _operator(
    queries: Queries,
    column: IntArray,
    weight: FloatArray,
    amount: FloatArray,
    shape: tuple[int, int],
) -> csr_array:
    from scipy.sparse import coo_array

    entry = weight * (amount[queries.light] * queries.cosine)[:, None]
    row = np.repeat(queries.pixel, weight.shape[1])
    keep = entry.ravel() != 0.0
    triplets = (entry.ravel()[keep], (row[keep], column.ravel()[keep]))
    return coo_array(triplets, shape=shape).tocsr()
