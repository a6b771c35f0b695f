"""What became of the items of a block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.reconstruct.compact.basis import LeadingBasis
from brdfit.reconstruct.compact.block import Block, Problem
from brdfit.reconstruct.compact.solve import Solution
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.outliers import FEWEST

__all__ = ["HALF", "BlockResult"]

HALF = 0.5
"""Responsibility below which a sample is named: more likely wrong than right."""


@dataclass(frozen=True, eq=False)
class BlockResult:
    """What became of the items of a block; NaN where one could not be fitted.

    | name             | shape        | meaning                                               |
    |------------------|--------------|-------------------------------------------------------|
    | `coefficients`   | (b, c, 1 + k)| of [tau | B]                                          |
    | `noise`          | (b,)         | s, relative noise of a good sample, ln f_r            |
    | `outlier_share`  | (b,)         | pi                                                    |
    | `deviation`      | (b,)         | standard deviation of ln f_r, rms over directions     |
    | `steps`          | (b,)         | rounds after the coarse ones                          |
    | `settled`        | (b,)         | whether the last changed next to nothing              |
    | `used`           | (b,)         | usable samples                                        |
    | `outliers`       | (b,)         | of them, more likely wrong than right                 |
    | `responsibility` | (rows,)      | r of every sample of the block, 0 for unused ones     |
    | `scatter`        | (rows,)      | variance of its ln f_r besides s^2                    |
    """

    coefficients: FloatArray
    noise: FloatArray
    outlier_share: FloatArray
    deviation: FloatArray
    steps: IntArray
    settled: BoolArray
    used: IntArray
    outliers: IntArray
    responsibility: FloatArray
    scatter: FloatArray
    failures: dict[int, str]

    @classmethod
    def empty(cls, block: Block, basis: LeadingBasis) -> BlockResult:
        """Return a result without any fit yet."""
        b, rows = len(block), len(block.samples)
        return cls(
            coefficients=np.full((b, block.samples.n_channels, basis.size), np.nan),
            noise=np.full(b, np.nan),
            outlier_share=np.full(b, np.nan),
            deviation=np.full(b, np.nan),
            steps=np.zeros(b, dtype=np.int32),
            settled=np.zeros(b, dtype=bool),
            used=block.per_item(block.used).astype(np.int32),
            outliers=np.zeros(b, dtype=np.int32),
            responsibility=np.zeros(rows),
            scatter=np.zeros(rows),
            failures=block.failures,
        )

    def __len__(self) -> int:
        return len(self.noise)

    def put(self, problem: Problem, solution: Solution) -> None:
        """Enter the solution of some items of the block."""
        index, rows = problem.index, problem.rows
        z = _numpy(solution.coefficients)
        self.coefficients[index] = z.reshape(len(index), -1, z.shape[-1])
        self.noise[index] = _numpy(solution.width)
        self.outlier_share[index] = _numpy(solution.share)
        self.deviation[index] = _numpy(solution.deviation)
        self.steps[index] = _numpy(solution.steps)
        self.settled[index] = _numpy(solution.settled)
        there = rows >= 0
        responsibility = _numpy(solution.responsibility)
        self.responsibility[rows[there]] = responsibility[there]
        self.scatter[rows[there]] = problem.scatter[there]
        known = there & problem.known
        self.outliers[index] = (known & (responsibility < HALF)).sum(axis=1)

    @property
    def outcomes(self) -> list[Outcome | None]:
        """How the fit of each item ended; None where there was nothing to fit."""
        return [self._outcome(item) for item in range(len(self))]

    def _outcome(self, item: int) -> Outcome | None:
        if item in self.failures:
            return None
        if self.used[item] < FEWEST:
            return Outcome.TOO_FEW_SAMPLES
        if 2 * self.outliers[item] > self.used[item]:
            return Outcome.MOSTLY_OUTLIERS
        return Outcome.CONVERGED if self.settled[item] else Outcome.ITERATION_LIMIT

    def figures(self, item: int) -> dict[str, float]:
        """Return the figures of an item, as a fit's history has them."""
        return {
            "noise": float(self.noise[item]),
            "outlier_share": float(self.outlier_share[item]),
            "deviation": float(self.deviation[item]),
        }


def _numpy(array: Any) -> FloatArray:
    return np.asarray(array.cpu() if hasattr(array, "cpu") else array)
