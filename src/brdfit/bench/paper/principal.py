"""`PcaRidge` as a column of the tables: one Gram matrix for all cases of a data ratio.

The same equations as `PcaRidge.fit`. Members that must not be leaned on are taken out of the
Gram matrix before the mean of the columns is: no product over the samples is repeated.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.bench.paper.contender import Answer, Case
from brdfit.bench.paper.scene import Scene
from brdfit.linalg import NormalEquations
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.pca_ridge import (
    LogRelative,
    PcaRidge,
    centred_gram,
    combined,
    cosine_product,
    principal_axes,
)
from brdfit.reconstruct.result import settings_record

__all__ = ["Principal"]

# Rows of the universe that the principal axes are found from.
_TRAINING_ROWS = 20_000


@dataclass(frozen=True, eq=False)
class _Columns:
    """L of every channel of every member at directions (m, K), and the cosines there (m,)."""

    values: FloatArray
    cosine: FloatArray

    @classmethod
    def of(cls, mapping: LogRelative, logs: FloatArray, wi: FloatArray, wo: FloatArray) -> _Columns:
        cosine = cosine_product(wi[:, 2], wo[:, 2])
        return cls(mapping.columns(MemberRows(tuple(logs)), cosine), cosine)

    def gram(self) -> FloatArray:
        values = self.values.astype(np.float64)
        return np.asarray(values.T @ values)


@dataclass(frozen=True, eq=False)
class _Prepared:
    samples: _Columns
    gram: FloatArray


@dataclass(eq=False)
class Principal:
    """Principal components with a ridge. All cases of a data ratio share a Gram matrix."""

    method: PcaRidge
    title: str = "Pca"
    cost: int = 20
    _scene: int = field(default=0, repr=False)
    _target: _Columns | None = field(default=None, repr=False)
    _training: FloatArray | None = field(default=None, repr=False)

    @property
    def metric(self) -> str | None:
        """It has a mapping of its own, none of the error metrics."""
        return None

    @property
    def _mapping(self) -> LogRelative:
        return LogRelative(self.method.epsilon)

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        found = settings_record(self.method)
        return {key: value for key, value in found.items() if key != "population"}

    def share(self, case: Case) -> Hashable:
        """Cases of a data ratio share their Gram matrix."""
        return case.places

    def prepare(self, scene: Scene, case: Case) -> _Prepared:
        """Return the columns at the samples, and their Gram matrix."""
        if self._scene != id(scene):
            self._scene, self._training = id(scene), None
            self._target = _Columns.of(self._mapping, scene.at_target, *scene.target)
        logs, directions = scene.at_universe[:, case.rows], scene.directions(case.rows)
        samples = _Columns.of(self._mapping, logs, *directions)
        return _Prepared(samples, samples.gram())

    def reconstruct(
        self, scene: Scene, prepared: _Prepared, case: Case, values: FloatArray
    ) -> Answer:
        """Return f_r (m, channels) at the target."""
        assert self._target is not None
        count = len(scene.names)
        others = scene.others(case.subject)
        columns = np.concatenate([others + count * c for c in range(scene.n_channels)])
        there = prepared.samples.values[:, columns].astype(np.float64)
        mean = there.mean(axis=1, keepdims=True)
        y = self._mapping.encode(values, prepared.samples.cosine) - mean
        moment = there.T @ y
        moment -= moment.mean(axis=0)
        gram = centred_gram(prepared.gram[np.ix_(columns, columns)])
        axes = self._axes(scene, columns, len(y))
        equations = NormalEquations(
            axes.T @ gram @ axes, axes.T @ moment, float(len(y)), np.sum(y**2, axis=0)
        )
        mapped = combined(self._target.values[:, columns], axes @ self.method.solve(equations))
        return Answer(self._mapping.decode(mapped, self._target.cosine))

    def _axes(self, scene: Scene, columns: IntArray, samples: int) -> FloatArray:
        """Return as many principal axes (K, k) as there are samples; the ridge needs no others.

        With all K the axes are a rotation, to which a ridge is blind.
        """
        if samples >= columns.size:
            return np.eye(columns.size)
        if self._training is None:
            rows = np.sort(scene.order[:_TRAINING_ROWS])
            logs, directions = scene.at_universe[:, rows], scene.directions(rows)
            training = _Columns.of(self._mapping, logs, *directions)
            self._training = training.gram()
        gram = centred_gram(self._training[np.ix_(columns, columns)])
        return principal_axes(gram)[:, :samples]
