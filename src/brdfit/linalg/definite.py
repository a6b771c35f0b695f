"""Inverses of very many small positive definite matrices, and what they make of vectors.

`inverse_by_halves` is the definition: array operations of any library. With S the Schur
complement of the upper left block P of [[P, Q], [Q^T, R]] and T = P^-1 Q,

    inverse = [[P^-1 + T S^-1 T^T, -T S^-1], [-S^-1 T^T, S^-1]]

LAPACK's elimination is made for large matrices; of small ones the products cost less. Where
numba is installed, numpy's many are inverted by compiled loops (`sweep`), in a fraction of the
time (`benchmarks/definite.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from brdfit.linalg.packed import Triangle

__all__ = ["inverse_by_halves", "solved", "sweep_if_compiled"]

# Matrices up to this size are inverted at once; fewer than so many do not repay a compilation.
_SMALL, _MANY = 16, 4


def solved(xp: Any, a: Any, right: Any, packed: bool = False) -> tuple[Any, Any]:
    """Return the inverses of positive definite matrices and their products with vectors.

    `a` is (..., k, k) or, `packed`, (..., p) as `Triangle` has it, of the library `xp`, and so
    is the inverse; `right` (..., m, k) are m vectors for each, and so is what becomes of them.
    The leading axes of `a` may be 1 where those of `right` are more: one matrix for all.
    """
    k = right.shape[-1]
    each_its_own = tuple(right.shape[:-2]) == tuple(a.shape[: -1 if packed else -2])
    if isinstance(a, np.ndarray) and each_its_own and right.size >= _MANY * right.shape[-2] * k:
        sweep = sweep_if_compiled()
        if sweep is not None:
            return _swept(sweep, a, right, packed)
    inverse = inverse_by_halves(xp, Triangle.of(k).unpack(xp, a) if packed else a)
    solution = xp.matmul(right, inverse)
    return (Triangle.of(k).pack(xp, inverse) if packed else inverse), solution


def _swept(
    sweep: Callable[..., None], a: np.ndarray, right: np.ndarray, packed: bool
) -> tuple[np.ndarray, np.ndarray]:
    vectors = np.ascontiguousarray(right).reshape(-1, *right.shape[-2:])
    flat = np.ascontiguousarray(a).reshape(len(vectors), -1)
    inverse, solution = np.empty_like(flat), np.empty_like(vectors)
    sweep(flat, vectors, packed, inverse, solution)
    return inverse.reshape(a.shape), solution.reshape(right.shape)


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
def sweep_if_compiled() -> Callable[..., None] | None:
    """Return the compiled `sweep.solve_each`; None without numba."""
    try:
        from brdfit.linalg.sweep import solve_each
    except ImportError:
        return None
    return solve_each  # type: ignore[no-any-return]
