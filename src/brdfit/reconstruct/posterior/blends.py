"""Blends: what two columns of a population make together, as further columns.

    ln(f_i / m_i + b f_j / m_j),     ln b ~ N(0, 0.3^2)

with m the geometric median of a column over cells of the MERL grid. Reflectance adds: a coat
over another body, a second lobe, a mixture of two materials is a sum of what each reflects.
In ln f_r, where the process is Gaussian, no sum of columns makes it, so that a population of
few columns has to be told. Pairs and scales are drawn once, of a fixed seed. A blend
counts as much as the geometric mean of its parents: with a parent left out, it is out as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray

__all__ = ["Blends"]

# Columns that a population is filled up to, and how many blends a column of its own allows.
_ENOUGH, _EACH = 1200, 3
_SPREAD = 0.3
_SEED = 1


@dataclass(frozen=True, eq=False)
class Blends:
    """Pairs of columns, and what is added to the logarithm of each of the two."""

    pairs: IntArray
    """(2, p)"""
    shifts: FloatArray
    """ln (2, p), float32"""

    @classmethod
    def of(cls, logs: FloatArray) -> Blends:
        """Draw pairs of the log columns `logs` (cells, columns)."""
        count = logs.shape[1]
        size = max(0, min(_ENOUGH - count, _EACH * count)) if count > 1 else 0
        random = np.random.default_rng(_SEED)
        pairs = random.integers(count, size=(2, size))
        shifts = -np.median(logs, axis=0)[pairs]
        shifts[1] += _SPREAD * random.standard_normal(size)
        return cls(pairs, shifts.astype(np.float32))

    def joined(self, logs: FloatArray) -> FloatArray:
        """Return the columns of `logs` (n, columns) and the blends, (n, columns + p)."""
        first, second = (
            logs[:, of_pair] + shift for of_pair, shift in zip(self.pairs, self.shifts, strict=True)
        )
        return np.hstack([logs, np.logaddexp(first, second)])

    def weights(self, weights: FloatArray) -> FloatArray:
        """Return the weights (columns + p,) of all, from those of the columns (columns,)."""
        return np.concatenate([weights, np.sqrt(weights[self.pairs].prod(axis=0))])
