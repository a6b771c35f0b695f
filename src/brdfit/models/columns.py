"""Parameters of analytic models: one value, or one per column (channel or material)."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from brdfit.arrays import frozen
from brdfit.errors import UsageError

__all__ = ["freeze_columns"]


def freeze_columns(model: Any) -> None:
    """Turn every field of a frozen dataclass into a read-only float64 array (columns,).

    Scalars are repeated. Raises `UsageError` where lengths disagree or a value is not
    finite. For `__post_init__` only.
    """
    names = [item.name for item in dataclasses.fields(model)]
    given = [np.atleast_1d(np.asarray(getattr(model, name), dtype=np.float64)) for name in names]
    size = max(array.size for array in given)
    for name, array in zip(names, given, strict=True):
        if array.ndim != 1 or array.size not in (1, size):
            raise UsageError(
                f"{type(model).__name__}: {name} has shape {array.shape} but the parameters "
                f"have {size} columns; give one value, or one per column."
            )
        if not np.isfinite(array).all():
            raise UsageError(f"{type(model).__name__}: {name} holds a value that is not finite.")
        object.__setattr__(model, name, frozen(np.broadcast_to(array, (size,))))
