"""The compiled product of a long matrix with very few columns; needs numba. See `thin`."""

from __future__ import annotations

import numpy as np

from brdfit.linalg.compiled import compiled_sums

__all__ = ["multiply"]

_FOUR = 4
_ZERO = np.float32(0.0)


@compiled_sums
def multiply(rows: np.ndarray, columns: np.ndarray, result: np.ndarray) -> None:
    """Write rows (n, k) times columns (c, k), each one's numbers together, to (n, c).

    Four rows at a time: each number of a column is read once for four products.
    """
    n, k = rows.shape
    whole = n // _FOUR * _FOUR
    for i in range(0, whole, _FOUR):
        r0, r1, r2, r3 = rows[i], rows[i + 1], rows[i + 2], rows[i + 3]
        for j in range(len(columns)):
            column = columns[j]
            s0, s1, s2, s3 = _ZERO, _ZERO, _ZERO, _ZERO
            for x in range(k):
                factor = column[x]
                s0 += r0[x] * factor
                s1 += r1[x] * factor
                s2 += r2[x] * factor
                s3 += r3[x] * factor
            result[i, j], result[i + 1, j] = s0, s1
            result[i + 2, j], result[i + 3, j] = s2, s3
    for i in range(whole, n):
        row = rows[i]
        for j in range(len(columns)):
            column = columns[j]
            s0 = _ZERO
            for x in range(k):
                s0 += row[x] * column[x]
            result[i, j] = s0
