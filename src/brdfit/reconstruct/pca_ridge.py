"""`PcaRidge`: principal components of the log-relative population, damped by a ridge.

    L(f) = ln(f c + epsilon),      c = clip(cos theta_i cos theta_o, 0.01, 1)

    L(rho~(x)) = mu(x) + sum_k a_k q_k(x)
    minimise  sum_i (L(rho_i) - mu(x_i) - sum_k a_k q_k(x_i))^2 + eta sum_k a_k^2

with mu the mean of L over the columns of the population, every channel of every member a
column, and q_k its principal components scaled by their singular values: with the centred
columns X = U S V^T over the cells of the MERL grid, q = U S = X V. So the q_k are known at any
direction where the members are, and V alone is what a population has to be analysed for. As
many components as samples are used, at most all.

The authors map ln((f c + epsilon) / (median + epsilon)), relative to the median column. Their
mean is taken out afterwards, and the median with it: the fit does not depend on it.

Reference: J. B. Nielsen, H. W. Jensen, R. Ramamoorthi, "On Optimal, Minimal BRDF Sampling for
Reflectance Acquisition", ACM Transactions on Graphics 34(6), 2015: the mapping, epsilon =
0.001, eta = 40. The cosine, its floor 0.01, and the number of components are those of the
code that the authors published with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import ClassVar

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import MERL_GRID, Grid
from brdfit.linalg import NormalEquations, one_thread, ridge
from brdfit.populations import Population, population, remember
from brdfit.progress import Progress, silent
from brdfit.reconstruct.checks import check_above
from brdfit.reconstruct.combination import equal_columns
from brdfit.reconstruct.correction_basis import training_cells
from brdfit.reconstruct.members import MemberRows, by_block
from brdfit.reconstruct.result import Reconstruction, direct_result, population_record
from brdfit.reconstruct.targets import Targets
from brdfit.samples import Samples

__all__ = [
    "LogRelative",
    "PcaModel",
    "PcaRidge",
    "centred_gram",
    "combined",
    "cosine_product",
    "principal_axes",
]

# Raise it when the principal axes of the same population would change.
_VERSION = 1
# Samples whose components are in memory at once: 40 MB for a population of 600 columns.
_CHUNK = 8192
_SMALLEST_COSINE = 0.01
# 1/sr. exp(L) - epsilon may come out at or below zero, of which there is no logarithm.
_SMALLEST = 1e-6


@dataclass(frozen=True)
class LogRelative:
    """The mapping L of values to the domain in which components are combined."""

    epsilon: float

    def columns(self, rows: MemberRows, cosine: FloatArray) -> FloatArray:
        """Return L of every channel of every member, (m, columns), at cosines c (m,)."""
        c = cosine.astype(np.float32)[:, None]
        return np.concatenate([self._of_log(log, c) for log in rows.logs], axis=1)

    def _of_log(self, log: FloatArray, c: FloatArray) -> FloatArray:
        value = np.exp(log)
        value *= c
        value += np.float32(self.epsilon)
        return np.asarray(np.log(value, out=value))

    def encode(self, value: FloatArray, cosine: FloatArray) -> FloatArray:
        """Return L of values f_r (m, c) >= 0 at cosines c (m,)."""
        return np.asarray(np.log(value * cosine[:, None] + self.epsilon))

    def decode(self, mapped: FloatArray, cosine: FloatArray) -> FloatArray:
        """Return f_r (m, c), held above 1e-6 / sr, of L at cosines c (m,)."""
        value = (np.exp(mapped) - self.epsilon) / cosine[:, None]
        return np.asarray(np.maximum(value, _SMALLEST))


@dataclass(frozen=True, eq=False)
class PcaModel:
    """A fitted combination of the columns of a population.

    `combination` (columns, c) is V a: the coefficients of the centred columns themselves.
    """

    population: Population
    mapping: LogRelative
    combination: FloatArray

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        found: list[FloatArray] = [np.empty((0, self.combination.shape[1]))]
        for rows in _chunks(len(wi)):
            members = MemberRows.at(self.population, wi[rows], wo[rows])
            found.append(self.values(members, cosine_product(wi[rows, 2], wo[rows, 2])))
        return np.concatenate(found)

    def values(self, members: MemberRows, cosine: FloatArray) -> FloatArray:
        """Return f_r (m, c) where the members and the cosines c (m,) are known."""
        columns = self.mapping.columns(members, cosine)
        return self.mapping.decode(combined(columns, self.combination), cosine)

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr; 0 below the horizon."""

        def values(members: MemberRows, cells: IntArray) -> FloatArray:
            cosines = cos_incident_outgoing(*grid.half_diff(cells))
            return self.values(members, cosine_product(*cosines))

        return grid.spread(by_block(self.population, grid, values, progress))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> None:
        """Return None: the method states no uncertainty."""
        return None


@dataclass(frozen=True)
class PcaRidge:
    """Principal components of the log-relative population with a ridge (Nielsen et al. 2015)."""

    name: ClassVar[str] = "pca_ridge"

    population: str | Population = "published"
    """Materials to analyse: published, nbrdf, an archive of networks, or a folder of MERL files."""
    eta: float = 40.0
    """Ridge on the coefficients of the scaled components; larger stays nearer to the mean."""
    epsilon: float = 0.001
    """1/sr: added to f_r cos theta_i cos theta_o before the logarithm; below it nothing counts."""

    def __post_init__(self) -> None:
        check_above("eta", self.eta, 0.0)
        check_above("epsilon", self.epsilon, 0.0)

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples` (any number of channels).

        All channels lean on all columns of the population, whatever their colour. Censored
        values are left out: least squares has no use for a bound. Raises `SampleError` where
        no sample is usable, `PopulationError` where the population cannot be had.
        """
        samples.require_usable()
        materials = population(self.population)
        mapping = LogRelative(self.epsilon)
        axes = _axes_of(materials, mapping, progress)
        targets = Targets.of(samples)
        known = targets.usable & ~targets.censored
        design = _Design(materials, mapping, samples)
        combination = np.zeros((len(axes), samples.n_channels))
        for channels in equal_columns(known.astype(np.float64), np.arange(samples.n_channels)):
            rows = np.flatnonzero(known[:, channels[0]])
            used = axes[:, : min(rows.size, len(axes))]
            equations = design.equations(rows, samples.value[np.ix_(rows, channels)], used)
            combination[:, channels] = used @ self.solve(equations)
        model = PcaModel(materials, mapping, combination)
        estimate = model.evaluate(*samples.safe_directions)
        return direct_result(self, samples, model, np.log(estimate), population_record(materials))

    def solve(self, equations: NormalEquations) -> FloatArray:
        """Return the coefficients a (k, c) of scaled components from their normal equations."""
        # eta is absolute, the damping of `ridge` relative to the number of samples
        return ridge(equations, (self.eta / equations.total,)).coefficients


def combined(columns: FloatArray, combination: FloatArray) -> FloatArray:
    """Return mu + sum_j (L_j - mu) b_j, (m, c), of columns L (m, K) and b = V a (K, c)."""
    mean = columns.mean(axis=1, dtype=np.float64)[:, None]
    # without a centred copy of the columns
    product = (columns @ combination.astype(columns.dtype)).astype(np.float64)
    return np.asarray(mean * (1.0 - combination.sum(axis=0)) + product)


def cosine_product(cos_i: FloatArray, cos_o: FloatArray) -> FloatArray:
    """Return c = clip(cos theta_i cos theta_o, 0.01, 1), (n,)."""
    return np.clip(np.asarray(cos_i) * np.asarray(cos_o), _SMALLEST_COSINE, 1.0)


@dataclass(frozen=True, eq=False)
class _Design:
    """The centred columns of a population at samples, a chunk at a time."""

    population: Population
    mapping: LogRelative
    samples: Samples

    def equations(self, rows: IntArray, values: FloatArray, axes: FloatArray) -> NormalEquations:
        """Return the normal equations of components X V (n, k) for values (n, c) at `rows`."""
        wi, wo = self.samples.safe_directions
        parts = []
        for chunk in _chunks(len(rows)):
            at = rows[chunk]
            cosine = cosine_product(wi[at, 2], wo[at, 2])
            members = MemberRows.at(self.population, wi[at], wo[at])
            columns = self.mapping.columns(members, cosine).astype(np.float64)
            mean = columns.mean(axis=1, keepdims=True)
            target = self.mapping.encode(values[chunk], cosine) - mean
            parts.append(NormalEquations.of((columns - mean) @ axes, target, np.ones(len(at))))
        return reduce(add, parts)


def centred_gram(gram: FloatArray) -> FloatArray:
    """Return X^T X of columns X whose mean over the columns was taken out, from L^T L.

    X = L (I - 1 1^T / K), so rows and columns of the Gram matrix lose their means.
    """
    rows = gram - gram.mean(axis=0)
    return np.asarray(rows - rows.mean(axis=1, keepdims=True))


def principal_axes(gram: FloatArray) -> FloatArray:
    """Return V (K, K) of X = U S V^T, largest singular value first, from X^T X (K, K)."""
    _, vectors = np.linalg.eigh(gram)
    return np.ascontiguousarray(vectors[:, ::-1])


def _axes_of(materials: Population, mapping: LogRelative, progress: Progress) -> FloatArray:
    """Return the principal axes of a population, computed once and kept in the cache."""

    def build() -> dict[str, FloatArray]:
        progress("principal components", 0, 1)
        cells = training_cells(MERL_GRID)
        wi, wo = MERL_GRID.directions(cells)
        members = MemberRows.at(materials, wi, wo)
        columns = mapping.columns(members, cosine_product(wi[:, 2], wo[:, 2])).astype(np.float64)
        axes = principal_axes(centred_gram(columns.T @ columns))
        progress("principal components", 1, 1)
        return {"axes": axes}

    key = f"{materials.fingerprint} {materials.selected} {mapping.epsilon!r} {_VERSION}"
    return remember("principal-axes", key, build)["axes"]


def _chunks(n: int) -> Iterator[slice]:
    for start in range(0, n, _CHUNK):
        yield slice(start, start + _CHUNK)
