"""Members of a population at some directions, and which of their channels a sample leans on."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.grid import Grid
from brdfit.linalg import one_thread, side_by_side
from brdfit.populations import VALUE_FLOOR, Columns, Population, columns
from brdfit.progress import Progress
from brdfit.samples import Samples

__all__ = ["MemberRows", "by_block", "channel_roles", "on_grid"]

# Rows of a block: bounds the memory of a population of 600 columns to 80 MB.
_CHUNK = 8192
# Directions evaluated at once: as many as sources take together, so that two threads share few.
_PIECE = 512
# Bands below and above these wavelengths (nm) lean on the blue and the red of the population.
_BLUE_BELOW, _RED_ABOVE = 490.0, 580.0
_LABEL = "dense result"
# Blocks evaluated side by side: enough for a desktop, bounded for its memory.
_THREADS = 4


@dataclass(frozen=True, eq=False)
class MemberRows:
    """ln f_r of k members at m directions: one float32 array (m, k) a population channel."""

    logs: tuple[FloatArray, ...]

    @classmethod
    def at(cls, population: Population, wi: FloatArray, wo: FloatArray) -> MemberRows:
        """Evaluate `population` at direction pairs (m, 3)."""
        n_channels, k = len(population.channels), len(population)
        logs = np.empty((n_channels, len(wi), k), dtype=np.float32)

        def put(number: int) -> None:
            rows = slice(number * _PIECE, (number + 1) * _PIECE)
            values = np.maximum(population.evaluate(wi[rows], wo[rows]), VALUE_FLOOR)
            logs[:, rows] = np.moveaxis(np.log(values, out=values), 2, 0)

        side_by_side(put, -(-len(wi) // _PIECE))
        return cls(tuple(logs))

    @classmethod
    def read(cls, dense: Columns, start: int, stop: int) -> MemberRows:
        """Take rows [start, stop) of the dense columns."""
        return cls(
            tuple(dense.block(c, start, stop) for c in range(len(dense.population.channels)))
        )

    def __len__(self) -> int:
        return int(self.logs[0].shape[0])

    @property
    def members(self) -> int:
        """Number of members k."""
        return int(self.logs[0].shape[1])

    def take(self, rows: IntArray | slice) -> MemberRows:
        """Return the same members at some of the directions."""
        return MemberRows(tuple(log[rows] for log in self.logs))

    def without(self, members: IntArray) -> MemberRows:
        """Return the same directions with the members of these indices left out."""
        return MemberRows(tuple(np.delete(log, members, axis=1) for log in self.logs))


def channel_roles(samples: Samples, population: Population) -> IntArray:
    """Return for each channel of the samples the population channel it is fitted by, (c,).

    Samples with the population's own channels pair up by name. A spectral band takes the
    nearest primary (below 490 nm blue, above 580 nm red, else green); anything else green.
    """
    names = list(population.channels)
    if set(samples.channels) <= set(names):
        return np.array([names.index(name) for name in samples.channels])
    middle = len(names) // 2
    if samples.wavelengths is None:
        same_count = samples.n_channels == len(names)
        return np.arange(len(names)) if same_count else np.full(samples.n_channels, middle)
    band = samples.wavelengths
    first, last = 0, len(names) - 1  # red comes first
    return np.where(band < _BLUE_BELOW, last, np.where(band > _RED_ABOVE, first, middle))


def on_grid(
    population: Population,
    grid: Grid,
    evaluate: Callable[[MemberRows], FloatArray],
    progress: Progress,
) -> FloatArray:
    """Return `evaluate` of the members at each of `grid.cells`, (cells, c), float32."""
    return by_block(population, grid, lambda rows, _: evaluate(rows), progress)


def by_block(
    population: Population,
    grid: Grid,
    evaluate: Callable[[MemberRows, IntArray], FloatArray],
    progress: Progress,
) -> FloatArray:
    """Return `evaluate` of members and their flat cells at `grid.cells`, (cells, c), float32.

    Streams over the dense columns block by block. A bilateral population has one row for
    two cells: it is evaluated once, and must not depend on which of the two it is.
    """
    dense = columns(population, grid, progress)
    starts = range(0, len(dense), _CHUNK)

    def block(start: int) -> FloatArray:
        rows = MemberRows.read(dense, start, start + _CHUNK)
        return evaluate(rows, dense.cells[start : start + _CHUNK]).astype(np.float32)

    # numpy lets go of the interpreter in its loops: two threads keep two cores busy
    blocks = []
    with one_thread(), ThreadPoolExecutor(_THREADS) as pool:
        for done, values in enumerate(pool.map(block, starts)):
            progress(_LABEL, done * _CHUNK, len(dense))
            blocks.append(values)
    progress(_LABEL, len(dense), len(dense))
    return np.concatenate(blocks)[dense.expand]
