"""Inverses of very many small positive definite matrices.

`inverse_by_halves` is the definition: array operations of any library. With S the Schur
complement of the upper left block P of [[P, Q], [Q^T, R]] and T = P^-1 Q,

    inverse = [[P^-1 + T S^-1 T^T, -T S^-1], [-S^-1 T^T, S^-1]]

LAPACK's elimination is made for large matrices; of small ones the products cost less. Where
numba is installed, numpy's many are inverted by a compiled sweep (Gauss-Jordan without pivots,
which a positive definite matrix does not need): a third of the time of `numpy.linalg.inv`
and half of that of the products (`benchmarks/definite.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

__all__ = ["inverse_by_halves", "inverses", "sweep_if_compiled"]

# Matrices up to this size are inverted at once; fewer than so many do not repay a compilation.
_SMALL, _MANY = 16, 32


def inverses(xp: Any, a: Any) -> Any:
    """Return the inverses of positive definite matrices (..., k, k) of the library `xp`."""
    if isinstance(a, np.ndarray) and a.ndim > 2 and a.size >= _MANY * a.shape[-1] ** 2:
        sweep = sweep_if_compiled()
        if sweep is not None:
            k = a.shape[-1]
            return sweep(np.ascontiguousarray(a).reshape(-1, k, k)).reshape(a.shape)
    return inverse_by_halves(xp, a)


def inverse_by_halves(xp: Any, a: Any) -> Any:
    """Return the inverses of positive definite matrices (..., k, k) by products of blocks."""
    k = a.shape[-1]
    if k <= _SMALL:
        return xp.linalg.inv(a)
    h = k // 2
    turn = (*range(len(a.shape) - 2), len(a.shape) - 1, len(a.shape) - 2)
    p = inverse_by_halves(xp, a[..., :h, :h])
    t = xp.matmul(p, a[..., :h, h:])
    t_turned = xp.permute_dims(t, turn)
    s = inverse_by_halves(xp, a[..., h:, h:] - xp.matmul(t_turned, a[..., :h, h:]))
    u = xp.matmul(t, s)
    upper = xp.concat([p + xp.matmul(u, t_turned), -u], axis=-1)
    lower = xp.concat([-xp.permute_dims(u, turn), s], axis=-1)
    return xp.concat([upper, lower], axis=-2)


@lru_cache(maxsize=1)
def sweep_if_compiled() -> Callable[[np.ndarray], np.ndarray] | None:
    """Return the compiled inverse of float64 (b, k, k); None without numba."""
    try:
        import numba
    except ImportError:
        return None
    try:
        compiled = numba.njit(cache=True)(_sweep)
    except RuntimeError:  # there is nowhere to keep what was compiled
        compiled = numba.njit(_sweep)
    return compiled  # type: ignore[no-any-return]


def _sweep(a: np.ndarray) -> np.ndarray:
    """Sweep every pivot of each matrix in turn; what is left is the inverse."""
    count, k, _ = a.shape
    result = a.copy()
    row = np.empty(k)
    for b in range(count):
        m = result[b]
        for p in range(k):
            pivot = 1.0 / m[p, p]
            for j in range(k):
                row[j] = m[p, j] * pivot
            for i in range(k):
                if i != p:
                    factor = m[i, p]
                    for j in range(k):
                        m[i, j] -= factor * row[j]
                    m[i, p] = -factor * pivot
            for j in range(k):
                m[p, j] = row[j]
            m[p, p] = pivot
    return result
