"""A table in R, G, B small enough to travel into a browser, at full resolution.

Half floats of f_r / scale; each plane of a channel as differences along the flat index (phi_d
runs fastest), modulo 2^16; the low bytes of all, then the high bytes; zlib. What
`viewer-client/src/render/packed.ts` takes apart, and `unpack` here.

Cells that hold nothing are filled with the nearest valid value along theta_d, so that the
linear filter of a graphics card never blends with an absence; `Table.evaluate` leaves such
corners out instead, which differs within a cell of the horizon.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import CorruptFile, UsageError
from brdfit.table import Table

__all__ = ["PackedTable"]

_LARGEST_HALF = 65504.0
_LEVEL = 1  # twice the level saves a tenth of the size and costs twice the time


@dataclass(frozen=True)
class PackedTable:
    """The packed bytes, and what is needed to read them."""

    shape: tuple[int, int, int]
    """n_theta_h, n_theta_d, n_phi_d"""
    scale: float
    """f_r is the half float times this."""
    content: bytes
    """zlib stream of 6 bytes a cell."""

    @classmethod
    def of(cls, table: Table) -> PackedTable:
        """Pack a table of three channels (`brdfit.report.rgb`) with at least one valid cell."""
        if table.n_channels != 3:
            raise UsageError(
                f"PackedTable: found {table.n_channels} channels but R, G and B are packed; see "
                f"brdfit.report.rgb.rgb_table."
            )
        if not table.mask.any():
            raise UsageError("PackedTable: the table holds no valid cell: there is nothing to see.")
        values = _filled(table.values, table.mask)
        largest = float(values.max())
        scale = max(1.0, largest / _LARGEST_HALF)
        half = np.ascontiguousarray(np.moveaxis(values / np.float32(scale), 3, 0), dtype="<f2")
        bits = half.reshape(3, -1).view("<u2")
        bits = np.diff(bits, axis=1, prepend=np.uint16(0))
        low_high = bits.reshape(-1).view(np.uint8).reshape(-1, 2).T
        content = zlib.compress(low_high.tobytes(), _LEVEL)
        return cls(table.grid.shape, scale, content)

    def unpack(self) -> FloatArray:
        """Return f_r (n_theta_h, n_theta_d, n_phi_d, 3) as a browser sees it, float32."""
        size = int(np.prod(self.shape))
        plain = zlib.decompress(self.content)
        if len(plain) != 6 * size:
            raise CorruptFile(f"PackedTable: found {len(plain)} bytes but {6 * size} were expected")
        low, high = np.frombuffer(plain, dtype=np.uint8).reshape(2, 3, size).astype(np.uint16)
        bits = np.cumsum(low | (high << 8), axis=1, dtype=np.uint16)
        half = bits.astype("<u2").view("<f2").reshape(3, *self.shape)
        return np.moveaxis(half, 0, 3).astype(np.float32) * np.float32(self.scale)


def _filled(values: FloatArray, mask: BoolArray) -> npt.NDArray[np.float32]:
    """Return the values with every invalid cell replaced along theta_d, else along theta_h."""
    filled = np.asarray(values, dtype=np.float32)
    for axis in (1, 0):
        if mask.all():
            break
        nearest = _nearest_along(mask, axis)
        filled = np.take_along_axis(filled, np.maximum(nearest, 0)[..., None], axis=axis)
        mask = nearest >= 0
    if not mask.all():
        filled = np.where(mask[..., None], filled, filled[mask].mean(axis=0))
    return filled


def _nearest_along(mask: BoolArray, axis: int) -> npt.NDArray[np.int64]:
    """Return the index along `axis` of the last valid cell before, else the next; -1 if none."""
    n = mask.shape[axis]
    position = np.arange(n, dtype=np.int64).reshape([-1 if a == axis else 1 for a in range(3)])
    before = np.maximum.accumulate(np.where(mask, position, -1), axis=axis)
    after = np.where(mask, position, n)
    after = np.flip(np.minimum.accumulate(np.flip(after, axis), axis=axis), axis)
    return np.where(before >= 0, before, np.where(after < n, after, -1))
