"""Products of long matrices with a few columns: as many rows as the library does in place."""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["thin_product"]

# Multiplications of a product that the library does in place; it packs the factors of larger
# ones, which for a few columns takes longer than to multiply.
_SMALL = 500_000


def thin_product(rows: FloatArray, columns: FloatArray) -> FloatArray:
    """Return rows (n, k) @ columns (k, c) for few columns, in the precision of both."""
    result = np.empty((len(rows), columns.shape[1]), dtype=np.result_type(rows, columns))
    step = max(_SMALL // max(columns.size, 1), 1)
    for start in range(0, len(rows), step):
        piece = slice(start, start + step)
        np.matmul(rows[piece], columns, out=result[piece])
    return result
