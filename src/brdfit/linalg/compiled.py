"""Compiles loops and keeps what was compiled; needs numba.

The interpreter is let go of while they run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

__all__ = ["compiled", "compiled_sums"]


def compiled(function: Callable[..., Any]) -> Any:
    """Return `function`, compiled when first called and kept beside its source."""
    return _compiled(function, {"contract"})


def compiled_sums(function: Callable[..., Any]) -> Any:
    """Return `function` compiled so that sums may be taken in any order: in whole registers."""
    return _compiled(function, {"contract", "reassoc", "nsz"})


def _compiled(function: Callable[..., Any], allowed: set[str]) -> Any:
    try:
        return numba.njit(cache=True, nogil=True, fastmath=allowed)(function)
    except RuntimeError:  # there is nowhere to keep what was compiled
        return numba.njit(nogil=True, fastmath=allowed)(function)
