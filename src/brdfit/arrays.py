"""Small named mathematics and the shape checks that raw arguments pass through.

Everything here is vectorised, allocates its result, and knows nothing of BRDFs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from brdfit.errors import UsageError

__all__ = [
    "UNIT_TOLERANCE",
    "BoolArray",
    "FloatArray",
    "IntArray",
    "as_columns",
    "as_directions",
    "as_unit_directions",
    "dot",
    "frozen",
    "normalize",
    "safe_arccos",
    "surely_finite",
]

UNIT_TOLERANCE = 1e-3
"""How far the length of a unit vector may be from 1: figures rounded to three decimals."""

FloatArray = npt.NDArray[np.floating[Any]]
"""An array of floats; shapes are given in each docstring."""

IntArray = npt.NDArray[np.integer[Any]]
"""An array of integers."""

BoolArray = npt.NDArray[np.bool_]
"""An array of booleans."""


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the inner product over the last axis."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def normalize(v: FloatArray) -> FloatArray:
    """Return `v` (..., 3) scaled to unit length; a null vector stays null.

    The null vector is the half vector of two opposite directions: the caller
    decides what that means, so nothing is divided by zero here.
    """
    length = np.sqrt(dot(v, v))[..., None]
    return np.asarray(v / np.where(length > 0.0, length, 1.0))


def safe_arccos(x: FloatArray) -> FloatArray:
    """Return arccos of `x` clipped to [-1, 1]: rounding must not make a NaN."""
    return np.asarray(np.arccos(np.clip(x, -1.0, 1.0)))


def frozen(array: npt.ArrayLike, dtype: npt.DTypeLike | None = None) -> npt.NDArray[Any]:
    """Return a read-only, contiguous copy that nobody else can write through."""
    copy = np.array(array, dtype=dtype, order="C", copy=True)
    copy.flags.writeable = False
    return copy


def surely_finite(values: FloatArray) -> bool:
    """Return True if all are finite, and none is so large that the sum of squares overflows.

    One pass that writes nothing: several times faster than to ask each.
    """
    flat = values.reshape(-1)
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(np.dot(flat, flat)))


def as_directions(name: str, value: npt.ArrayLike) -> FloatArray:
    """Return `value` as float64 (n, 3), or say what was found instead.

    A single direction (3,) becomes (1, 3). Length is not changed.
    """
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 1 and array.shape == (3,):
        array = array[None, :]
    if array.ndim != 2 or array.shape[1] != 3:
        raise UsageError(
            f"{name}: found an array of shape {array.shape} but directions are unit vectors "
            f"of shape (n, 3), normal = +z. From angles use brdfit.directions_from_spherical."
        )
    return array


def as_unit_directions(name: str, value: npt.ArrayLike) -> FloatArray:
    """Return `value` as `as_directions` does; raise `UsageError` where a length is not 1.

    A direction that is not finite passes: what it yields is NaN.
    """
    array = as_directions(name, value)
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.sqrt(dot(array, array))
    wrong = np.abs(length - 1.0) > UNIT_TOLERANCE
    wrong &= np.isfinite(array).all(axis=1)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise UsageError(
            f"{name}: found a vector of length {length[row]:g} in row {row} "
            f"({int(wrong.sum())} such rows of {len(array)}) but directions are unit vectors. "
            f"Divide each by its length."
        )
    return array


def as_columns(name: str, value: npt.ArrayLike, n: int) -> FloatArray:
    """Return `value` as float64 (n, channels); (n,) becomes one channel."""
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[0] != n or array.shape[1] == 0:
        raise UsageError(
            f"{name}: found an array of shape {np.shape(value)} but expected ({n}, channels), "
            f"one row for each of the {n} directions."
        )
    return array
