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
    "HIGHEST",
    "LOWEST",
    "Between",
    "Lines",
    "add_rows",
    "loops_if_compiled",
    "plain_add_rows",
    "plain_put_lines",
    "plain_put_values",
    "put_lines",
    "put_values",
]

LOWEST, HIGHEST = np.float32(-30.0), np.float32(30.0)
"""ln f_r: what is written stays within what a float32 and a renderer can hold."""
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
    (plain_put_values if loops is None else loops.put_values)(logs, highest, LOWEST, cells)


@dataclass(frozen=True, eq=False)
class Between:
    """Places along an axis, each between two nodes of it."""

    low: IntArray
    """(n,), int32: one of the nodes..."""
    high: IntArray
    """(n,), int32: ...and the other."""
    weight: FloatArray
    """(2, n), float32: of the one, and of the other."""

    @classmethod
    def of(cls, matrix: FloatArray) -> Between:
        """Return those that a matrix (n, nodes) describes: a row has at most two numbers."""
        there, at = matrix != 0.0, np.arange(len(matrix))
        low = there.argmax(axis=1)
        high = matrix.shape[1] - 1 - there[:, ::-1].argmax(axis=1)
        weight = np.stack([matrix[at, low], np.where(high > low, matrix[at, high], 0.0)])
        return cls(low.astype(np.int32), high.astype(np.int32), weight.astype(np.float32))

    def each(self, channels: int) -> Between:
        """Return the same along nodes that have so many numbers, one beside the other."""
        channel = np.arange(channels, dtype=np.int32)
        low, high = (
            (at[:, None] * np.int32(channels) + channel).reshape(-1) for at in (self.low, self.high)
        )
        return Between(low, high, np.repeat(self.weight, channels, axis=1))


@dataclass(frozen=True, eq=False)
class Lines:
    """How cells come from nodes, one theta_d after the other: a line is what has one theta_d.

    There are a few kinds of lines: those that the horizon cuts at the same phi_d are the same.
    """

    along_d: Between
    along_phi: Between
    scale: FloatArray
    """(kinds, phi), float32: what ln f_r is multiplied by."""
    highest: FloatArray
    """(kinds, phi), float32: the largest that it may be; -inf where there is nothing: f_r is 0."""

    @lru_cache(maxsize=4)  # noqa: B019 - a few, kept as long as what made them is
    def each(self, channels: int) -> Lines:
        """Return the same for cells and nodes of so many channels."""
        scale, highest = (np.repeat(a, channels, axis=1) for a in (self.scale, self.highest))
        return Lines(self.along_d, self.along_phi.each(channels), scale, highest)


def put_lines(
    nodes: FloatArray, lines: Lines, kind: IntArray, constant: FloatArray, cells: FloatArray
) -> None:
    """Put f_r into cells (rings, d, phi); ln f_r is scale times what is between nodes, and more.

    More is a constant (phi,), the nodes are (rings, d nodes, phi nodes), `kind` (rings, d) says
    of which kind each line is. All are float32; phi stands for phi and channels (`Lines.each`).
    """
    d, phi = lines.along_d, lines.along_phi
    loops = loops_if_compiled()
    if loops is None:
        plain_put_lines(nodes, lines, kind, constant, cells)
        return
    between = (d.low, d.high, d.weight, phi.low, phi.high, phi.weight)
    loops.put_lines(nodes, *between, kind, lines.scale, lines.highest, constant, LOWEST, cells)


def plain_put_lines(
    nodes: FloatArray, lines: Lines, kind: IntArray, constant: FloatArray, cells: FloatArray
) -> None:
    """`put_lines` by array operations, one theta_h after the other."""
    d, phi = lines.along_d, lines.along_phi
    share, rest = (weight[:, None] for weight in d.weight)
    for values, which, found in zip(nodes, kind, cells, strict=True):
        around = phi.weight[0] * values.take(phi.low, axis=1)
        around += phi.weight[1] * values.take(phi.high, axis=1)
        logs = share * around.take(d.low, axis=0)
        logs += rest * around.take(d.high, axis=0)
        logs *= lines.scale.take(which, axis=0)
        logs += constant
        np.maximum(logs, LOWEST, out=logs)
        np.minimum(logs, lines.highest.take(which, axis=0), out=logs)
        np.exp(logs, out=found)


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
