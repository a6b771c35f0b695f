"""Write MERL `.binary` files."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import DataQualityWarning, UsageError
from brdfit.files import atomic_path
from brdfit.formats.merl.layout import HEADER, NOT_MEASURED, SCALES
from brdfit.grid import MERL_GRID
from brdfit.table import Table

__all__ = ["write_table"]

_NAMES = (("r", "g", "b"), ("red", "green", "blue"))


def write_table(table: Table, path: Path) -> None:
    """Write a table on the MERL grid with R, G and B, or one channel three times.

    Cells that are not valid are written as not measured (-1 in all channels). The format
    cannot tell a value below zero from "not measured": such values of valid cells become
    0, with a `DataQualityWarning` that counts them.

    Raises `UsageError` for another grid or other channels.
    """
    _check_grid(table, path)
    pick = _channels(table, path)
    mask = table.mask
    negative = int(np.count_nonzero((table.values < 0.0) & mask[..., None]))
    with atomic_path(path) as aside, open(aside, "wb") as stream:
        stream.write(struct.pack("<3i", *HEADER))
        for channel, scale in zip(pick, SCALES, strict=True):
            value = np.where(mask, table.values[..., channel], 0.0).astype(np.float64)
            stored = _stored(np.maximum(value, 0.0), scale, path)
            stream.write(np.where(mask, stored, NOT_MEASURED).astype("<f8").tobytes())
    if negative:
        warnings.warn(
            f"{path.name}: {negative:,} values below zero were written as 0, because a MERL table "
            f"means 'not measured' by a negative number. Write .npz to keep them.",
            DataQualityWarning,
            stacklevel=2,
        )


def _check_grid(table: Table, path: Path) -> None:
    if table.grid != MERL_GRID:
        found = " x ".join(str(size) for size in table.grid.shape)
        raise UsageError(
            f"{path.name}: the table has {found} cells but a MERL file has 90 x 90 x 180. Write "
            f"it as .npz, or evaluate it on brdfit.MERL_GRID first."
        )


def _channels(table: Table, path: Path) -> tuple[int, int, int]:
    """Return which channels of the table become R, G and B."""
    if table.n_channels == 1:
        return (0, 0, 0)
    names = tuple(name.lower() for name in table.channels)
    if names in _NAMES and table.wavelengths is None:
        return (0, 1, 2)
    shown = ", ".join(table.channels[:4]) + (", ..." if table.n_channels > 4 else "")
    raise UsageError(
        f"{path.name}: the table has {table.n_channels} channels ({shown}) but a MERL file has R, "
        f"G and B. Convert it to linear sRGB first (brdfit.render does that for spectral data), or "
        f"write it as .npz."
    )


def _stored(value: FloatArray, scale: float, path: Path) -> FloatArray:
    """Return the numbers to store, which the reader multiplies by `scale`.

    Reading and writing again gives the same bytes. With m(x) in [1, 2) the mantissa of x:
    if m(stored) >= m(value), rounding the quotient moved it by less than half a unit in the
    last place of `value`, so the reader gets `value` itself; if not, what the reader gets
    differs from `value`, but by less than half a unit in the last place of `stored`.
    """
    stored = value / scale
    if not np.isfinite(stored).all():
        raise UsageError(
            f"{path.name}: the largest value is {value.max():g} 1/sr, too large for a MERL file."
        )
    return stored
