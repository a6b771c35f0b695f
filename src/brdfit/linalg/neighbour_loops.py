"""The compiled systems of kriging from neighbours; needs numba. See `neighbours`."""

from __future__ import annotations

import numpy as np

from brdfit.linalg.compiled import compiled_sums

__all__ = ["solve_each"]

# Rounding may take a pivot below zero where rows coincide and their noise is small.
_LEAST = 1e-12


@compiled_sums
def solve_each(
    places: np.ndarray,
    values: np.ndarray,
    nugget: np.ndarray,
    index: np.ndarray,
    distance: np.ndarray,
    scale: float,
    mean: np.ndarray,
    variance: np.ndarray,
) -> None:
    """Write to mean (m, c), variance (m,) what rows `index` (m, k), so far away, say.

    With `scale` sqrt(3) / reach. The factor of kappa(Z, Z) + diag nugget is made row by row.
    """
    m, k = index.shape
    factor, inverse = np.empty((k, k)), np.empty(k)
    z, u = np.empty((k, places.shape[1])), np.empty(k)
    for p in range(m):
        for i in range(k):
            z[i] = places[index[p, i]]
        for i in range(k):
            own = factor[i]
            for j in range(i):
                square = 0.0
                for x in range(z.shape[1]):
                    difference = z[i, x] - z[j, x]
                    square += difference * difference
                d = scale * np.sqrt(square)
                own[j] = (1.0 + d) * np.exp(-d)
            for j in range(i):
                total = own[j]
                other = factor[j]
                for x in range(j):
                    total -= own[x] * other[x]
                own[j] = total * inverse[j]
            pivot = 1.0 + nugget[index[p, i]]
            d = scale * distance[p, i]
            told = (1.0 + d) * np.exp(-d)
            for x in range(i):
                pivot -= own[x] * own[x]
                told -= own[x] * u[x]
            inverse[i] = 1.0 / np.sqrt(max(pivot, _LEAST))
            u[i] = told * inverse[i]
        left = 1.0
        for i in range(k):
            left -= u[i] * u[i]
        variance[p] = min(max(left, 0.0), 1.0)
        mean[p] = 0.0
        for i in range(k - 1, -1, -1):
            weight = u[i] * inverse[i]
            row = values[index[p, i]]
            for x in range(len(row)):
                mean[p, x] += weight * row[x]
            own = factor[i]
            for x in range(i):
                u[x] -= weight * own[x]
