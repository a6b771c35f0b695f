"""What is done to ln f_r of one theta_h, cell by cell, until it is f_r in a table.

Array operations are the definition. Where numba is installed, compiled loops (`slab_loops`) do
the same in one pass each, within 1e-6 in ln f_r (`benchmarks/dense_loops.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import ModuleType

import numpy as np

from brdfit.arrays import FloatArray, IntArray

__all__ = [
    "Between",
    "add_rows",
    "blended",
    "loops_if_compiled",
    "plain_add_rows",
    "plain_put_values",
    "put_blended",
    "put_values",
]

# ln f_r: the lowest that is written.
_LOWEST = np.float32(-30.0)
# Channels up to which one after the other is faster than all in their order.
_FEW = 4


def add_rows(logs: FloatArray, rows: FloatArray, row_of: IntArray, constant: FloatArray) -> None:
    """Add to logs (channels, n) the row (m, channels) that each cell has, and a constant.

    The constant is (channels,); all are float32.
    """
    loops = loops_if_compiled()
    (plain_add_rows if loops is None else loops.add_rows)(logs, rows, row_of, constant)


def put_values(logs: FloatArray, highest: FloatArray, cells: FloatArray) -> None:
    """Put f_r into cells (n, channels), float32; ln f_r, logs (channels, n), is used up.

    `highest` (n,) is the largest that ln f_r may be; -inf where there is nothing: f_r is 0.
    """
    loops = loops_if_compiled()
    (plain_put_values if loops is None else loops.put_values)(logs, highest, _LOWEST, cells)


@dataclass(frozen=True, eq=False)
class Between:
    """Places along an axis, each between two neighbouring nodes."""

    matrix: FloatArray
    """(d, m), float32: what linear interpolation makes of m nodes; a row has two numbers."""
    low: IntArray
    """(d,) the lower node"""
    weight: FloatArray
    """(d, 2), float32: of the lower, and of the one above it"""

    @classmethod
    def of(cls, matrix: FloatArray) -> Between:
        """Return those that a matrix describes."""
        low = np.minimum((matrix != 0.0).argmax(axis=1), matrix.shape[1] - 2)
        weight = np.take_along_axis(matrix, low[:, None] + np.arange(2), axis=1)
        return cls(matrix, low, weight)


def blended(
    nodes: FloatArray, between: Between, scale: FloatArray, constant: FloatArray
) -> FloatArray:
    """Return scale (h, d, phi) times nodes (h, channels, m, phi) blended along theta_d, and more.

    More is a constant (channels,). The result is (h, channels, d * phi), all of it float32.
    """
    result = np.asarray(np.matmul(between.matrix, nodes))
    result *= scale[:, None]
    result += constant[:, None, None]
    return result.reshape(*nodes.shape[:2], -1)


def put_blended(
    nodes: FloatArray,
    between: Between,
    scale: FloatArray,
    constant: FloatArray,
    highest: FloatArray,
    cells: FloatArray,
) -> None:
    """Do `put_values` to what is `blended`: highest (h, d * phi), cells (h, d * phi, channels)."""
    loops = loops_if_compiled()
    if loops is not None:
        low, weight = between.low, between.weight
        loops.put_blended(nodes, low, weight, scale, constant, highest, _LOWEST, cells)
        return
    for ring in range(len(nodes)):
        one = slice(ring, ring + 1)
        logs = blended(nodes[one], between, scale[one], constant)[0]
        put_values(logs, highest[ring], cells[ring])


def plain_add_rows(
    logs: FloatArray, rows: FloatArray, row_of: IntArray, constant: FloatArray
) -> None:
    """`add_rows` by array operations."""
    for channel, known in enumerate(np.add(rows.T, constant[:, None], order="C")):
        logs[channel] += known.take(row_of, mode="clip")


def plain_put_values(
    logs: FloatArray, highest: FloatArray, lowest: np.float32, cells: FloatArray
) -> None:
    """`put_values` by array operations."""
    np.maximum(logs, lowest, out=logs)
    np.minimum(logs, highest, out=logs)
    np.exp(logs, out=logs)
    if len(logs) > _FEW:
        cells[:] = logs.T
        return
    for channel, values in enumerate(logs):
        cells[:, channel] = values


@lru_cache(maxsize=1)
def loops_if_compiled() -> ModuleType | None:
    """Return `slab_loops`; None without numba."""
    try:
        from brdfit.reconstruct import slab_loops
    except ImportError:
        return None
    return slab_loops
