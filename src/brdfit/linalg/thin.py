"""Products of long matrices with a few columns: nothing is copied, rows are read once.

What the library does in place, a piece at a time, is the definition. Where numba is installed,
a compiled loop (`thin_loops`) multiplies by very few columns: it takes hardly longer than to
read the rows (`benchmarks/dense_loops.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["plain_thin_product", "thin_product"]

# Multiplications of a product that the library does in place; it packs the factors of larger
# ones, which for a few columns takes longer than to multiply.
_SMALL = 500_000
# Columns up to which the loop is faster.
_FEW = 8


def thin_product(rows: FloatArray, columns: FloatArray) -> FloatArray:
    """Return rows (n, k) @ columns (k, c) for few columns, in the precision of both."""
    if rows.dtype == columns.dtype == np.float32 and columns.shape[1] <= _FEW:
        loop = _loop_if_compiled()
        if loop is not None:
            result = np.empty((len(rows), columns.shape[1]), dtype=np.float32)
            loop(np.ascontiguousarray(rows), np.ascontiguousarray(columns.T), result)
            return result
    return plain_thin_product(rows, columns)


def plain_thin_product(rows: FloatArray, columns: FloatArray) -> FloatArray:
    """`thin_product` by the library's products."""
    result = np.empty((len(rows), columns.shape[1]), dtype=np.result_type(rows, columns))
    step = max(_SMALL // max(columns.size, 1), 1)
    for start in range(0, len(rows), step):
        piece = slice(start, start + step)
        np.matmul(rows[piece], columns, out=result[piece])
    return result


@lru_cache(maxsize=1)
def _loop_if_compiled() -> Callable[..., None] | None:
    """Return the compiled `thin_loops.multiply`; None without numba."""
    try:
        from brdfit.linalg.thin_loops import multiply
    except ImportError:
        return None
    return multiply  # type: ignore[no-any-return]
