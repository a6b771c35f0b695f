"""The correction basis: how each material differs from what the other materials make of it.

For every member M_i, and each of its channels, the remaining materials approximate it by a
non-negative combination rho~ (`combination`), and

    C_i(x) = M_i(x) / rho~(x)

is a correction function (poster, "Correction basis"). C_i is never stored on a grid: given
the members at any directions and one small matrix of coefficients a channel, it follows. All
leave-one-out combinations come from one Gram matrix a channel.

The correction functions of all channels together are one basis, used for every channel of
every measurement: colour hardly changes how a material departs from the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.grid import MERL_GRID, Grid
from brdfit.linalg import NormalEquations, nonnegative
from brdfit.populations import Population, remember
from brdfit.progress import Progress
from brdfit.reconstruct.combination import combine, encode_members
from brdfit.reconstruct.members import MemberRows
from brdfit.transform import ErrorMetric

__all__ = ["CorrectionBasis", "MemberGram", "correction_basis", "training_cells"]

# Raise it when the coefficients of the same population would change.
_VERSION = 2
# Cells of the MERL grid that the leave-one-out combinations are fitted to, and the seed of
# their draw. The members are asked there: no dense columns are needed.
_TRAINING_CELLS = 20_000
_SEED = 1409
# |ln C| is held to this: a combination that vanishes somewhere must not blow a correction up.
_LOG_RANGE = 3.0


@dataclass(frozen=True, eq=False)
class MemberGram:
    """X^T X of the encoded members, one matrix a population channel."""

    metric: ErrorMetric
    grams: tuple[FloatArray, ...]

    @classmethod
    def of(cls, rows: MemberRows, metric: ErrorMetric) -> MemberGram:
        """Sum over the rows in float64: small eigenvalues matter."""
        grams = []
        for log in rows.logs:
            x = encode_members(log.astype(np.float64), metric)
            grams.append(x.T @ x)
        return cls(metric, tuple(grams))

    def without(self, members: IntArray) -> MemberGram:
        """Leave out the members of these indices."""
        return MemberGram(
            self.metric,
            tuple(np.delete(np.delete(g, members, 0), members, 1) for g in self.grams),
        )


@dataclass(frozen=True, eq=False)
class CorrectionBasis:
    """`coefficients[channel][i]` combine the other materials' members into member i."""

    metric: ErrorMetric
    coefficients: tuple[FloatArray, ...]

    @classmethod
    def build(cls, gram: MemberGram, materials: tuple[str, ...]) -> CorrectionBasis:
        """Solve the leave-one-material-out combination of every member and channel."""
        group = np.unique(np.array(materials), return_inverse=True)[1]
        return cls(gram.metric, tuple(_leave_one_out(g, group) for g in gram.grams))

    @cached_property
    def size(self) -> int:
        """Number of correction functions."""
        return sum(len(matrix) for matrix in self.coefficients)

    def evaluate(self, rows: MemberRows) -> FloatArray:
        """Return C_i at the rows' directions, (m, size), float32."""
        k = rows.members
        result = np.empty((len(rows), self.size), dtype=np.float32)
        for channel, (log, matrix) in enumerate(zip(rows.logs, self.coefficients, strict=True)):
            combined = combine(log, self.metric, matrix)
            # in place: on a whole grid these arrays are what takes the time
            log_c = np.subtract(log, combined, out=result[:, channel * k : (channel + 1) * k])
            np.clip(log_c, -_LOG_RANGE, _LOG_RANGE, out=log_c)
            np.exp(log_c, out=log_c)
        return result


def _leave_one_out(gram: FloatArray, group: IntArray) -> FloatArray:
    k, size = len(group), len(gram)
    free = size - k  # the constant of the log domain
    result = np.zeros((k, size))
    for i in range(k):
        others = np.append(np.flatnonzero(group != group[i]), np.arange(k, size))
        if len(others) == size - k:  # no other material: nothing to correct, C_i = 1
            result[i, i] = 1.0
            continue
        equations = NormalEquations(
            gram[np.ix_(others, others)], gram[others, i], 1.0, np.array(gram[i, i])
        )
        result[i, others] = nonnegative(equations, free)
    return result


def training_cells(grid: Grid) -> IntArray:
    """Return the cells (flat) that the leave-one-out combinations are fitted to."""
    rng = np.random.default_rng(_SEED)
    return np.sort(rng.choice(grid.cells, min(_TRAINING_CELLS, grid.cells.size), replace=False))


def correction_basis(
    population: Population, metric: ErrorMetric, progress: Progress
) -> CorrectionBasis:
    """Return the correction basis of a population, computed once and kept in the cache."""

    def build() -> dict[str, np.ndarray]:
        progress("correction basis", 0, 1)
        rows = MemberRows.at(population, *MERL_GRID.directions(training_cells(MERL_GRID)))
        basis = CorrectionBasis.build(MemberGram.of(rows, metric), population.materials)
        progress("correction basis", 1, 1)
        return {str(c): matrix for c, matrix in enumerate(basis.coefficients)}

    key = f"{population.fingerprint} {population.selected} {metric.name} {_VERSION}"
    arrays = remember("correction-basis", key, build)
    return CorrectionBasis(metric, tuple(arrays[str(c)] for c in range(len(arrays))))
