"""The compiled inverse of very many small positive definite matrices; needs numba.

`definite` says what it computes. Of a symmetric T, with B four of its rows and columns, D the
block where they cross and C the rest of the columns, sweeping B means

    T <- T - C D^-1 C^T,     C <- C D^-1,     D <- -D^-1

and once everything is swept T is minus its inverse; rows b^T below it, which are never swept
themselves, have become b^T times the inverse. Only the lower triangle is kept. Four at a time,
a number is read and written once for four products. A definite matrix needs no search for
pivots.
"""

from __future__ import annotations

import numpy as np

from brdfit.linalg.compiled import compiled

__all__ = ["solve_each"]

_FOUR = 4
# Rows are updated up to a multiple of so many numbers: whole registers, no remainders.
_REGISTER = 8


@compiled
def solve_each(
    a: np.ndarray, right: np.ndarray, packed: bool, inverse: np.ndarray, solution: np.ndarray
) -> None:
    """Write the inverse of each matrix of `a`, and its product with each row of `right`.

    `a` and `inverse` are (b, k k) or, packed, (b, k (k + 1) / 2): the lower triangle, row
    after row. `right` and `solution` are (b, m, k).
    """
    many, k = right.shape[1:]
    size = -(-k // _FOUR) * _FOUR
    rows = size + -(-many // 2) * 2
    width = -(-rows // _REGISTER) * _REGISTER
    t = np.zeros((rows, width))
    columns, factors = np.zeros((_FOUR, width)), np.zeros((_FOUR, width))
    block = np.zeros((_FOUR, _FOUR))
    for item in range(len(a)):
        _read(a[item], packed, k, size, t)
        t[size : size + many, :k] = right[item]
        t[size:, k:] = 0.0
        for first in range(0, size, _FOUR):
            _take(t, first, columns, block)
            _invert(block)
            _multiply(block, columns, factors)
            _subtract(t, columns, factors)
            _put(t, first, factors, block)
        _write(t, packed, k, inverse[item])
        solution[item] = t[size : size + many, :k]


@compiled
def _read(a: np.ndarray, packed: bool, k: int, size: int, t: np.ndarray) -> None:
    """Copy the lower triangle; what is added to fill the last four is the identity."""
    at = 0
    for i in range(k):
        if not packed:
            at = i * k
        for j in range(i + 1):
            t[i, j] = a[at + j]
        at += i + 1
    for i in range(k, size):
        for j in range(i):
            t[i, j] = 0.0
        t[i, i] = 1.0


@compiled
def _take(t: np.ndarray, first: int, columns: np.ndarray, block: np.ndarray) -> None:
    """Copy C, transposed and 0 within the block, and D."""
    for r in range(_FOUR):
        row = first + r
        for j in range(first):
            columns[r, j] = t[row, j]
        for j in range(first, first + _FOUR):
            columns[r, j] = 0.0
        for j in range(first + _FOUR, len(t)):
            columns[r, j] = t[j, row]
        for j in range(r + 1):
            block[r, j] = t[row, first + j]
            block[j, r] = t[row, first + j]


@compiled
def _invert(block: np.ndarray) -> None:
    """Replace D by its inverse: Gauss-Jordan, one pivot after the other."""
    for p in range(_FOUR):
        pivot = 1.0 / block[p, p]
        for i in range(_FOUR):
            if i != p:
                factor = block[i, p] * pivot
                for j in range(_FOUR):
                    if j != p:
                        block[i, j] -= factor * block[p, j]
                block[i, p] = -factor
        for j in range(_FOUR):
            if j != p:
                block[p, j] *= pivot
        block[p, p] = pivot


@compiled
def _multiply(block: np.ndarray, columns: np.ndarray, factors: np.ndarray) -> None:
    """Multiply: factors = D^-1 C^T."""
    c0, c1, c2, c3 = columns[0], columns[1], columns[2], columns[3]
    for r in range(_FOUR):
        d0, d1, d2, d3 = block[r, 0], block[r, 1], block[r, 2], block[r, 3]
        factor = factors[r]
        for j in range(len(factor)):
            factor[j] = d0 * c0[j] + d1 * c1[j] + d2 * c2[j] + d3 * c3[j]


@compiled
def _subtract(t: np.ndarray, columns: np.ndarray, factors: np.ndarray) -> None:
    """T - C D^-1 C^T, two rows at a time; what lies above the diagonal has no meaning."""
    c0, c1, c2, c3 = columns[0], columns[1], columns[2], columns[3]
    for i in range(0, len(t), 2):
        u0, u1, u2, u3 = factors[0, i], factors[1, i], factors[2, i], factors[3, i]
        h = i + 1
        v0, v1, v2, v3 = factors[0, h], factors[1, h], factors[2, h], factors[3, h]
        upper, lower = t[i], t[h]
        for j in range(-(-(i + 2) // _REGISTER) * _REGISTER):
            x0, x1, x2, x3 = c0[j], c1[j], c2[j], c3[j]
            y = upper[j] - u0 * x0 - u1 * x1 - u2 * x2 - u3 * x3
            z = lower[j] - v0 * x0 - v1 * x1 - v2 * x2 - v3 * x3
            upper[j] = y
            lower[j] = z


@compiled
def _put(t: np.ndarray, first: int, factors: np.ndarray, block: np.ndarray) -> None:
    """C D^-1 and -D^-1 in their places."""
    for r in range(_FOUR):
        row = first + r
        for j in range(first):
            t[row, j] = factors[r, j]
        for j in range(first + _FOUR, len(t)):
            t[j, row] = factors[r, j]
        for j in range(r + 1):
            t[row, first + j] = -block[r, j]


@compiled
def _write(t: np.ndarray, packed: bool, k: int, inverse: np.ndarray) -> None:
    at = 0
    for i in range(k):
        for j in range(i + 1):
            inverse[at + j] = -t[i, j]
        if packed:
            at += i + 1
            continue
        for j in range(i):
            inverse[j * k + i] = -t[i, j]
        at += k
