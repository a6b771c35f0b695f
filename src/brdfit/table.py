"""A dense BRDF on a grid, with a mask of the cells that hold something."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, as_directions, frozen
from brdfit.errors import UsageError
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.samples import Source, default_channels

__all__ = ["Table"]


@dataclass(frozen=True, eq=False)
class Table:
    """Dense values on a `Grid`, frozen.

    | name          | shape                                   | unit and range              |
    |---------------|-----------------------------------------|-----------------------------|
    | `values`      | (n_theta_h, n_theta_d, n_phi_d, channels) | f_r, 1/sr                 |
    | `valid`       | (n_theta_h, n_theta_d, n_phi_d)         | bool; False = holds nothing |
    | `wavelengths` | (channels,)                             | nm, or None                 |

    `valid` is intersected with `grid.above_horizon` and with "all channels finite"; left
    out, that is what it is. Values of invalid cells are kept as given but never used.
    """

    values: FloatArray
    grid: Grid = MERL_GRID
    valid: BoolArray | None = None
    wavelengths: FloatArray | None = None
    channels: tuple[str, ...] = ()
    source: Source = Source()

    def __post_init__(self) -> None:
        put = object.__setattr__
        values = np.asarray(self.values)
        if values.shape == self.grid.shape:
            values = values[..., None]
        if values.ndim != 4 or values.shape[:3] != self.grid.shape:
            raise UsageError(
                f"Table: found values of shape {values.shape} but the grid wants "
                f"{self.grid.shape} and a last axis of channels."
            )
        if not values.flags.writeable and values.flags.c_contiguous and values.base is None:
            put(self, "values", values)
        else:
            put(self, "values", frozen(values))
        n = values.shape[3]
        if self.wavelengths is not None:
            put(self, "wavelengths", frozen(np.atleast_1d(self.wavelengths), np.float64))
        channels = tuple(self.channels) or default_channels(n, self.wavelengths)
        if len(channels) != n:
            raise UsageError(f"Table: found {len(channels)} channel names but {n} channels.")
        put(self, "channels", channels)
        valid = self.grid.above_horizon & np.isfinite(values).all(axis=3)
        if self.valid is not None:
            valid = valid & np.asarray(self.valid, dtype=bool)
        put(self, "valid", frozen(valid))

    @property
    def n_channels(self) -> int:
        """Number of channels."""
        return int(self.values.shape[3])

    @cached_property
    def mask(self) -> BoolArray:
        """`valid`, never None."""
        assert self.valid is not None
        return self.valid

    @cached_property
    def missing(self) -> int:
        """Number of cells above the horizon that hold nothing."""
        return int(np.count_nonzero(self.grid.above_horizon & ~self.mask))

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels) at direction pairs (n, 3); 0 below the horizon.

        Trilinear between the valid nodes around the point, periodic across the phi_d
        seam. Where none of the eight is valid (a point within a cell of the horizon, or
        in a hole) the nearest valid cell answers; a table without any valid cell gives NaN.
        """
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        index, weight = self.grid.corners(*half_diff_from_directions(wi, wo))
        result = self.interpolate(index, weight)
        above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
        return np.where(above[:, None], result, 0.0)

    def interpolate(self, index: IntArray, weight: FloatArray) -> FloatArray:
        """Return values (n, channels) from `Grid.corners`, over the valid corners only."""
        index, share = self.valid_corners(index, weight)
        flat = self.values.reshape(-1, self.n_channels)
        gathered = np.where(share[..., None] == 0.0, 0.0, flat[index])
        return np.asarray(np.einsum("nc,nck->nk", share, gathered))

    def valid_corners(self, index: IntArray, weight: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return (flat indices, weights), each (n, 8), of the valid cells that answer.

        The weights of `Grid.corners` without the invalid cells, scaled to sum to 1. Where
        none of the eight is valid, the nearest valid cell of the heaviest has weight 1; a
        table without any valid cell gives NaN weights.
        """
        share = weight * self.mask.reshape(-1)[index]
        total = share.sum(axis=1)
        share /= np.where(total > 0.0, total, 1.0)[:, None]
        lost = total <= 0.0
        if not self.mask.any():
            share[:, 0] = np.nan
        elif np.any(lost):
            heaviest = index[lost, np.argmax(weight[lost], axis=1)]
            index = index.copy()
            index[lost] = self._valid_neighbour.reshape(-1)[heaviest][:, None]
            share[lost, 0] = 1.0
        return index, share

    @cached_property
    def _valid_neighbour(self) -> np.ndarray:
        # SciPy only here: most uses of a table never leave the valid cells.
        from scipy.ndimage import distance_transform_edt

        near = distance_transform_edt(~self.mask, return_distances=False, return_indices=True)
        return np.asarray(np.ravel_multi_index(tuple(near), self.grid.shape))
