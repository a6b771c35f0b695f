"""The two products that a fit of many rows waits for, by two threads.

    Phi^T W Phi                 rows phi (n, d), each of its own weight
    L^-1 B                      L lower triangular (d, d), B (d, m)

How the work is shared out depends on its size alone, never on who is free: the same numbers
come out every time. L^-1 B goes block by block of L,

    X_k = L_kk^-1 (B_k - sum_j<k L_kj X_j),

so that almost all of it are products, for which numpy lets go of the interpreter; SciPy's
triangular solver does not.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.linalg.threads import side_by_side

__all__ = ["forward", "weighted_gram"]

# Multiplications below which a second thread is not worth the call.
_WORTH_IT = 50_000_000
# Rows of a block of L, and columns of B that are worked on together: they stay in the cache.
_BLOCK, _TOGETHER = 128, 512


def weighted_gram(rows: FloatArray, weights: FloatArray) -> FloatArray:
    """Return Phi^T W Phi (d, d) of rows (n, d) and weights (n,) >= 0, all float64."""
    root = np.sqrt(weights)[:, None]
    n, d = rows.shape
    if n * d * d < _WORTH_IT:
        scaled = rows * root
        return np.asarray(scaled.T @ scaled)
    grams = np.empty((2, d, d))

    def add_up(half: int) -> None:
        own = slice(0, n // 2) if half == 0 else slice(n // 2, n)
        scaled = rows[own] * root[own]
        np.matmul(scaled.T, scaled, out=grams[half])

    side_by_side(add_up, 2)
    grams[0] += grams[1]
    return np.asarray(grams[0])


def forward(factor: FloatArray, right: FloatArray) -> FloatArray:
    """Return L^-1 B (d, m) from L (d, d), of which the lower triangle is read, and B (d, m)."""
    from scipy.linalg import solve_triangular

    d, m = right.shape
    if d * d * m < _WORTH_IT:
        return np.asarray(solve_triangular(factor, right, lower=True, check_finite=False))
    inverses = [
        solve_triangular(factor[at, at], np.eye(len(factor[at])), lower=True, check_finite=False)
        for at in _blocks(d)
    ]
    result = np.empty((d, m))

    def solve(number: int) -> None:
        some = slice(number * _TOGETHER, (number + 1) * _TOGETHER)
        x = np.array(right[:, some], order="C")
        for at, inverse in zip(_blocks(d), inverses, strict=True):
            x[at] = inverse @ (x[at] - factor[at, : at.start] @ x[: at.start])
        result[:, some] = x

    side_by_side(solve, -(-m // _TOGETHER))
    return result


def _blocks(size: int) -> list[slice]:
    return [slice(start, min(start + _BLOCK, size)) for start in range(0, size, _BLOCK)]
