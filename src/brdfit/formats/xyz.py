"""Linear sRGB as tristimulus values and back, for formats that hold X, Y and Z."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import DataQualityWarning, UsageError
from brdfit.table import Table

__all__ = [
    "linear_rgb_from_xyz",
    "not_negative",
    "refuse_other_channels",
    "xyz_from_linear_rgb",
]

_RGB = (("r", "g", "b"), ("red", "green", "blue"))

# Columns: X, Y, Z of the primaries of sRGB (IEC 61966-2-1), white D65.
_XYZ_OF_RGB = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)


def linear_rgb_from_xyz(xyz: FloatArray) -> FloatArray:
    """Return linear sRGB (..., 3) of tristimulus values (..., 3) relative to D65."""
    return np.asarray(xyz @ np.linalg.inv(_XYZ_OF_RGB).T)


def xyz_from_linear_rgb(rgb: FloatArray) -> FloatArray:
    """Return tristimulus values (..., 3) of linear sRGB (..., 3)."""
    return np.asarray(rgb @ _XYZ_OF_RGB.T)


def refuse_other_channels(table: Table, path: Path, format: str) -> None:
    """Raise `UsageError` unless the table has one channel, or R, G and B."""
    names = tuple(name.lower() for name in table.channels)
    if table.n_channels == 1 or (names in _RGB and table.wavelengths is None):
        return
    raise UsageError(
        f"{path.name}: the table has {table.n_channels} channels but {format} holds one, or R, G "
        f"and B. Convert it to linear sRGB first, or write it as .npz."
    )


def not_negative(values: FloatArray, path: Path) -> FloatArray:
    """Return `values` with what is below zero as 0, and a `DataQualityWarning` that counts it.

    Raises `UsageError` where values are missing: a table without any valid cell.
    """
    if not np.isfinite(values).all():
        raise UsageError(f"{path.name}: the table has no valid cell, so there is nothing to write.")
    negative = int(np.count_nonzero(values < 0.0))
    if negative:
        warnings.warn(
            f"{path.name}: {negative:,} values below zero were written as 0.",
            DataQualityWarning,
            stacklevel=4,
        )
    return np.maximum(values, 0.0)
