"""What this machine can do at best, and the least time that a stage can take on it.

    floor = max(bytes / bandwidth, operations / rate)

Bandwidth is that of copying a block much larger than the caches, what is read and what is
written both counted; the rates are those of square matrix products, a multiplication and an
addition being two operations. Both with the threads that the linear algebra has.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["Floor", "Machine"]

_BLOCK = 1 << 27
_EDGE = 1024
_TRIES = 5


@dataclass(frozen=True)
class Machine:
    """Bytes and operations a second."""

    bandwidth: float
    single: float
    """Operations a second of a float32 matrix product."""
    double: float
    """The same of float64."""

    @classmethod
    def measured(cls, block: int = _BLOCK, edge: int = _EDGE) -> Machine:
        """Measure with blocks of so many bytes and matrices of that edge."""
        source = np.ones(block // 4, dtype=np.float32)
        target = np.empty_like(source)
        copying = _fastest(lambda: np.copyto(target, source))
        operations = 2.0 * edge**3
        single = operations / _fastest(_product(np.ones((edge, edge), dtype=np.float32)))
        double = operations / _fastest(_product(np.ones((edge, edge), dtype=np.float64)))
        return cls(2.0 * source.nbytes / copying, single, double)


@dataclass(frozen=True)
class Floor:
    """What cannot be left out, however a stage is done."""

    moved: int
    """Bytes that must be read or written, each once."""
    single: float = 0.0
    """Operations in float32."""
    double: float = 0.0
    """Operations in float64."""
    why: str = ""
    """What was counted, in words."""

    def memory_seconds(self, machine: Machine) -> float:
        """Return how long the bytes take."""
        return self.moved / machine.bandwidth

    def product_seconds(self, machine: Machine) -> float:
        """Return how long the operations take."""
        return self.single / machine.single + self.double / machine.double

    def seconds(self, machine: Machine) -> float:
        """Return the longer of the two: they may overlap."""
        return max(self.memory_seconds(machine), self.product_seconds(machine))


def _product(square: FloatArray) -> Callable[[], object]:
    target = np.empty_like(square)
    return lambda: np.matmul(square, square, out=target)


def _fastest(work: Callable[[], object]) -> float:
    found = []
    for _ in range(_TRIES):
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return min(found)
