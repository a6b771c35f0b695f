"""The local residual: a smooth Gaussian process that lets a material leave its population.

    x = (stretch sqrt(theta_h / (pi/2)),  theta_d / (pi/2),  r cos 2 phi_d,  r sin 2 phi_d)
    r = sin theta_h sin theta_d

    k(x, x') = a^2 (1 + sqrt(3) d) exp(-sqrt(3) d),     d = |x - x'| / length

a Matern kernel of smoothness 3/2 over coordinates that know of reciprocity, and in which phi_d
has no say at the poles. Kernels that are products along (theta_h, theta_d, phi_d) are cheaper
on a grid, but predicted real measurements worse: what changes fast in phi_d changes where
theta_h and theta_d are large, and there only.

On a grid the sum over the samples is taken at nodes that are coarser than its cells and carried
to them by cubic splines along each axis: it is smooth, and most of the work is saved.

Reference: C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT
Press 2006, section 4.2.1 (Matern).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid
from brdfit.reconstruct.coordinates import half_diff_features

__all__ = ["Angles", "Kernel"]

Angles = tuple[FloatArray, FloatArray, FloatArray]
"""theta_h, theta_d, phi_d, each (n,), radians."""

# Nodes along theta_h (even in its square root), theta_d and phi_d.
_NODES = (46, 31, 48)
# Values of the kernel worked out together: what is next done to them finds them in the cache.
_IN_CACHE = 1 << 17


@dataclass(frozen=True)
class Kernel:
    """Length scale, how much longer theta_h is, and the amplitude a in ln f_r."""

    length: float
    stretch: float
    amplitude: float

    def coordinates(self, angles: Angles) -> FloatArray:
        """Return x / length (n, 4)."""
        x = half_diff_features(*(np.asarray(angle, dtype=np.float64) for angle in angles))
        x[:, 0] *= self.stretch
        return np.asarray(x / self.length)

    def between(self, one: Angles, other: Angles) -> FloatArray:
        """Return k (n, m), float64."""
        return self._of_coordinates(self.coordinates(one), self.coordinates(other))

    def on_grid(self, grid: Grid, centres: Angles, alpha: FloatArray) -> FloatArray:
        """Return sum_j k(x, centre_j) alpha_j, float32, for every cell, (h, d, phi, c)."""
        axes = _node_axes(grid)
        theta_h, theta_d, phi_d = (np.ravel(axis) for axis in np.meshgrid(*axes, indexing="ij"))
        x, z = self.coordinates((theta_h, theta_d, phi_d)), self.coordinates(centres)
        at_nodes = self._summed(x, z, alpha)
        return _carried(at_nodes.reshape(*(len(axis) for axis in axes), -1), axes, grid)

    def _summed(self, x: FloatArray, z: FloatArray, alpha: FloatArray) -> FloatArray:
        """Return sum_j k(x, z_j) alpha_j (n, c), float32, from x / length (n, 4) and (m, 4).

        3 d^2 = (x, |x|^2, 1) . 3 (-2 z, 1, |z|^2) is one product.
        """
        # Distances are differences of squares: from the middle the squares are small.
        middle = z.mean(axis=0) if len(z) else 0.0
        x, z = x - middle, z - middle
        left = np.column_stack([x, (x * x).sum(axis=1), np.ones(len(x))]).astype(np.float32)
        right = 3.0 * np.vstack([-2.0 * z.T, np.ones(len(z)), (z * z).sum(axis=1)])
        right, weights = right.astype(np.float32), (self.amplitude**2 * alpha).astype(np.float32)
        result = np.empty((len(x), weights.shape[1]), dtype=np.float32)
        step = min(max(1, _IN_CACHE // max(len(z), 1)), len(x))
        room = np.empty((2, step, len(z)), dtype=np.float32)
        for start in range(0, len(x), step):
            rows = slice(start, start + step)
            d, falling = room[:, : len(left[rows])]
            np.matmul(left[rows], right, out=d)
            _matern(d, falling)
            np.matmul(d, weights, out=result[rows])
        return result

    def _of_coordinates(self, x: FloatArray, z: FloatArray) -> FloatArray:
        """Return k from x / length (n, 4) and (m, 4), in their precision."""
        d = (-2.0 * x) @ z.T
        d += (x * x).sum(axis=1)[:, None]
        d += (z * z).sum(axis=1)
        d *= 3.0
        _matern(d, np.empty_like(d))
        d *= self.amplitude**2
        return np.asarray(d)


def _matern(d: FloatArray, room: FloatArray) -> None:
    """Put (1 + sqrt(s)) exp(-sqrt(s)) in place of s = 3 d^2; `room` is of its shape."""
    np.maximum(d, 0.0, out=d)
    np.sqrt(d, out=d)
    np.negative(d, out=room)
    np.exp(room, out=room)
    d += 1.0
    d *= room


def _node_axes(grid: Grid) -> Angles:
    """Return nodes along each axis that cover the grid's, no more than it has."""
    h, d, phi = (
        min(most, axis.size)
        for most, axis in zip(_NODES, (grid.theta_h, grid.theta_d, grid.phi_d), strict=True)
    )
    root = np.sqrt(grid.theta_h)
    step = np.pi / phi
    return (
        np.linspace(root[0], root[-1], h) ** 2,
        np.linspace(grid.theta_d[0], grid.theta_d[-1], d),
        step * np.arange(phi),
    )


def _carried(values: FloatArray, axes: Angles, grid: Grid) -> FloatArray:
    """Carry `values` (h, d, phi, c) at nodes to the cells of a grid."""
    along_h = _spline(np.sqrt(axes[0]), np.sqrt(grid.theta_h))
    along_d = _spline(axes[1], grid.theta_d)
    around = _spline(axes[2], np.mod(grid.phi_d, np.pi), period=np.pi)
    part: FloatArray = np.einsum("ia,abkc->ibkc", along_h, values, optimize=True)
    part = np.einsum("jb,ibkc->ijkc", along_d, part, optimize=True)
    return np.asarray(np.einsum("lk,ijkc->ijlc", around, part, optimize=True))


def _spline(nodes: FloatArray, at: FloatArray, period: float | None = None) -> FloatArray:
    """Return the matrix (len(at), len(nodes)), float32, of cubic spline interpolation."""
    from scipy.interpolate import CubicSpline, make_interp_spline

    if len(nodes) < 4:
        nearest = np.abs(at[:, None] - nodes).argmin(axis=1)
        return np.asarray(np.eye(len(nodes), dtype=np.float32)[nearest])
    if period is None:
        matrix: FloatArray = make_interp_spline(nodes, np.eye(len(nodes)), k=3)(at)
        return matrix.astype(np.float32)
    closed = np.append(nodes, nodes[0] + period)
    unit = np.eye(len(nodes))
    around = CubicSpline(closed, np.vstack([unit, unit[:1]]), bc_type="periodic")
    return np.asarray(around(at), dtype=np.float32)
