"""A dense BRDF on a grid, with a mask of the cells that hold something."""

from __future__ import annotations

from dataclasses import InitVar, dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, as_unit_directions, frozen, surely_finite
from brdfit.display import Shown
from brdfit.errors import UsageError
from brdfit.geometry import half_diff_from_directions, split_by_horizon
from brdfit.grid import MERL_GRID, Grid
from brdfit.samples import Source, name_channels

__all__ = ["Table"]


@dataclass(frozen=True, eq=False)
class Table(Shown):
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
    known_finite: InitVar[bool] = False
    """True: whoever made the values saw that all of them are finite, and they are not asked again.
    An argument only: those of a table made from this one are."""

    def __post_init__(self, known_finite: bool) -> None:
        put = object.__setattr__
        values = np.asarray(self.values)
        if values.shape == self.grid.shape:
            values = values[..., None]
        if values.ndim != 4 or values.shape[:3] != self.grid.shape:
            raise UsageError(
                f"Table: found values of shape {values.shape} but the grid wants "
                f"{self.grid.shape} and a last axis of channels."
            )
        if values.dtype.kind != "f":
            values = values.astype(np.float64)
        names, wavelengths = name_channels(
            "Table", values.shape[3], self.channels, self.wavelengths
        )
        put(self, "channels", names)
        put(self, "wavelengths", wavelengths)
        # A read-only array that owns its memory was handed over: MERL tables are 35 MB each.
        owned = not values.flags.writeable and values.flags.c_contiguous and values.base is None
        values = values if owned else frozen(values)
        put(self, "values", values)
        valid = self.grid.above_horizon
        if not (known_finite or surely_finite(values)):
            valid = valid & np.isfinite(values).all(axis=3)
        if self.valid is not None:
            given = np.asarray(self.valid, dtype=bool)
            if given.shape != self.grid.shape:
                raise UsageError(
                    f"Table: found a valid mask of shape {given.shape} but the grid wants "
                    f"{self.grid.shape}."
                )
            valid = valid & given
        # Either the grid's own, read-only already, or made here.
        valid.flags.writeable = False
        put(self, "valid", valid)

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
        """Return f_r (n, channels) at direction pairs (n, 3).

        0 below the horizon, NaN where a direction is not finite. Raises `UsageError` for
        vectors that are not of unit length.

        Trilinear between the valid nodes around the point, periodic across the phi_d
        seam. Where none of the eight is valid (a point within a cell of the horizon, or
        in a hole) the nearest valid cell answers; a table without any valid cell gives NaN.
        """
        wi, wo = as_unit_directions("wi", wi), as_unit_directions("wo", wo)
        finite, above = split_by_horizon(wi, wo)
        result = np.full((len(above), self.n_channels), np.nan)
        result[finite] = 0.0
        index, weight = self.grid.corners(*half_diff_from_directions(wi[above], wo[above]))
        result[above] = self.interpolate(index, weight)
        return result

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
            index[lost] = self.nearest_valid.reshape(-1)[heaviest][:, None]
            share[lost, 0] = 1.0
        return index, share

    @cached_property
    def nearest_valid(self) -> IntArray:
        """Flat index of the valid cell nearest to each cell, shaped as the grid."""
        # SciPy only here: most uses of a table never leave the valid cells.
        from scipy.ndimage import distance_transform_edt

        # Half a turn of phi_d on either side: the nearest cell may lie across the seam.
        n = self.grid.n_phi_d
        wrapped = np.concatenate([self.mask[..., n // 2 :], self.mask, self.mask[..., : n // 2]], 2)
        near = distance_transform_edt(~wrapped, return_distances=False, return_indices=True)
        i, j, k = near[..., n - n // 2 : 2 * n - n // 2]
        return np.asarray(np.ravel_multi_index((i, j, (k - (n - n // 2)) % n), self.grid.shape))
