"""`Tabulated` as a linear operator: interpolation weights that all materials share.

An interpolant by radial basis functions through values y at places x_1 ... x_n, evaluated at
x, is linear in y: with the k nearest samples, kernel matrix K, polynomials P,

    f(x) = [k(x), p(x)] [[K, P], [P^T, 0]]^{-1} [y, 0] = w(x) y

The weights w depend on the places alone, so a benchmark of many materials at the same places
solves for them once. Same neighbours, kernel, degree and averaging of coinciding samples as the
method's own interpolator; a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.reconstruct.tabulated import Tabulated

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["TabOperator"]

_SAME_PLACE = 1e-7
_SMALLEST = 1e-6
# Systems solved at once: 64 neighbours make 70 MB of them.
_CHUNK = 2048


def _thin_plate_spline(r: FloatArray) -> FloatArray:
    positive = np.where(r > 0.0, r, 1.0)
    return np.asarray(r**2 * np.log(positive))


_KERNELS: dict[str, tuple[Callable[[FloatArray], FloatArray], int]] = {
    "linear": (lambda r: -r, 0),
    "thin_plate_spline": (_thin_plate_spline, 1),
    "cubic": (lambda r: r**3, 1),
}
"""Kernel of the distance, and the degree of the polynomial part."""


@dataclass(frozen=True, eq=False)
class TabOperator:
    """Weights (m, n) from n samples to m places, sparse."""

    weights: csr_array

    @classmethod
    def build(cls, method: Tabulated, samples: FloatArray, places: FloatArray) -> TabOperator:
        """Return the operator between features (n, 4) and (m, 4) for the method's settings."""
        from scipy.sparse import csr_array
        from scipy.spatial import KDTree

        distinct, averaging = _averaging(samples)
        k = min(method.neighbors, len(distinct))
        _, nearest = KDTree(distinct).query(places, k)
        nearest = np.sort(np.reshape(nearest, (len(places), k)), axis=1)
        weight = np.empty((len(places), k), dtype=np.float32)
        for start in range(0, len(places), _CHUNK):
            rows = slice(start, start + _CHUNK)
            weight[rows] = _local_weights(method.kernel, distinct[nearest[rows]], places[rows])
        pointer = np.arange(0, weight.size + 1, k)
        local = csr_array(
            (weight.ravel(), nearest.ravel().astype(np.int32), pointer),
            shape=(len(places), len(distinct)),
        )
        return cls((local @ averaging).tocsr())

    def apply(self, values: FloatArray) -> FloatArray:
        """Return f_r (m, c) from values (n, c), held above 1e-6 as the method does it."""
        return np.asarray(np.maximum(self.weights @ values.astype(np.float32), _SMALLEST))


def _averaging(features: FloatArray) -> tuple[FloatArray, csr_array]:
    """Return the distinct places, and the matrix that averages what coincides there."""
    from scipy.sparse import csr_array

    key = np.rint(features / _SAME_PLACE).astype(np.int64)
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    place = np.ravel(place)
    share = (1.0 / np.bincount(place)[place]).astype(np.float32)
    column: IntArray = np.arange(len(features))
    shape = (len(first), len(features))
    return features[first], csr_array((share, (place, column)), shape=shape)


def _local_weights(kernel: str, neighbors: FloatArray, places: FloatArray) -> FloatArray:
    """Return the weights (b, k) of the neighbours (b, k, 4) in the value at each place (b, 4)."""
    function, degree = _KERNELS[kernel]
    b, k, _ = neighbors.shape
    between = np.zeros((b, k, k))
    for axis in np.moveaxis(neighbors, 2, 0):
        between += (axis[:, :, None] - axis[:, None, :]) ** 2
    np.sqrt(between, out=between)
    toward = np.linalg.norm(neighbors - places[:, None], axis=2)
    # Polynomials in coordinates brought to [-1, 1] per neighbourhood, for the condition.
    low, high = neighbors.min(axis=1), neighbors.max(axis=1)
    middle, half = (low + high) / 2, (high - low) / 2
    half[half == 0.0] = 1.0
    powers = 1 if degree == 0 else 1 + places.shape[1]
    system = np.zeros((b, k + powers, k + powers))
    right = np.ones((b, k + powers))
    system[:, :k, :k], right[:, :k] = function(between), function(toward)
    system[:, :k, k] = system[:, k, :k] = 1.0
    if degree:
        linear = (neighbors - middle[:, None]) / half[:, None]
        system[:, :k, k + 1 :], right[:, k + 1 :] = linear, (places - middle) / half
        system[:, k + 1 :, :k] = np.swapaxes(linear, 1, 2)
    # The system is symmetric: its solution for [k(x), p(x)] is the row of weights.
    return np.asarray(np.linalg.solve(system, right[..., None])[:, :k, 0])
