"""The MERL grid: nodes in (theta_h, theta_d, phi_d), the warp of theta_h, which cells exist.

A `Grid` has n_theta_h x n_theta_d x n_phi_d nodes (90 x 90 x 180 for MERL):

    theta_h[i] = (i / n_theta_h)^2 pi/2      dense near the specular peak
    theta_d[j] = (j / n_theta_d)   pi/2
    phi_d[k]   = (k / n_phi_d)     pi        [0, pi) by reciprocity; node n_phi_d is node 0

The flat index is k + n_phi_d (j + n_theta_d i), as in the file format (Matusik et al. 2003).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, frozen
from brdfit.errors import UsageError
from brdfit.geometry import cos_incident_outgoing, directions_from_half_diff, wrap_phi_d

__all__ = ["MERL_GRID", "Grid"]

# cos(theta) of a node that lies on the horizon up to rounding.
_HORIZON = 1e-9


@dataclass(frozen=True)
class Grid:
    """Nodes in half/difference coordinates; equal sizes make equal grids."""

    n_theta_h: int = 90
    n_theta_d: int = 90
    n_phi_d: int = 180

    def __post_init__(self) -> None:
        for name, size in zip(("n_theta_h", "n_theta_d", "n_phi_d"), self.shape, strict=True):
            if size < 2:
                raise UsageError(f"Grid: {name} is {size} but a grid needs at least 2 nodes.")

    @property
    def shape(self) -> tuple[int, int, int]:
        """(n_theta_h, n_theta_d, n_phi_d)."""
        return (self.n_theta_h, self.n_theta_d, self.n_phi_d)

    @property
    def size(self) -> int:
        """Number of cells, below the horizon included."""
        return self.n_theta_h * self.n_theta_d * self.n_phi_d

    @cached_property
    def theta_h(self) -> FloatArray:
        """Nodes (n_theta_h,), radians, square-root warped."""
        return frozen((np.arange(self.n_theta_h) / self.n_theta_h) ** 2 * (np.pi / 2))

    @cached_property
    def theta_d(self) -> FloatArray:
        """Nodes (n_theta_d,), radians."""
        return frozen(np.arange(self.n_theta_d) / self.n_theta_d * (np.pi / 2))

    @cached_property
    def phi_d(self) -> FloatArray:
        """Nodes (n_phi_d,), radians in [0, pi)."""
        return frozen(np.arange(self.n_phi_d) / self.n_phi_d * np.pi)

    @cached_property
    def above_horizon(self) -> BoolArray:
        """Which cells exist, shape `shape`: wi and wo of the *node* strictly above the horizon.

        For MERL that is 1,111,430 of 1,458,000. The 1,105,588 quoted in the literature is
        an empirical count, cells that every measured file of the database has; the rules at
        the middle of a cell give 1,096,216 (all axes) to 1,104,118 (theta_d only).
        """
        cos_i, cos_o = cos_incident_outgoing(
            self.theta_h[:, None, None], self.theta_d[None, :, None], self.phi_d[None, None, :]
        )
        return frozen((cos_i > _HORIZON) & (cos_o > _HORIZON))

    @cached_property
    def cells(self) -> IntArray:
        """Flat indices of the cells above the horizon, ascending."""
        return frozen(np.flatnonzero(self.above_horizon))

    def spread(self, values: FloatArray) -> FloatArray:
        """Return values (cells.size, c) of the cells above the horizon in their places.

        Shape (*shape, c), float32; 0 below the horizon.
        """
        result = np.zeros((self.size, values.shape[1]), dtype=np.float32)
        result[self.cells] = values
        return result.reshape(*self.shape, -1)

    @cached_property
    def solid_angle(self) -> FloatArray:
        """Measure of each cell above the horizon, shape `shape`, summing to 1; 0 below.

        d(omega_i) d(omega_o) = 4 cos(theta_d) d(omega_h) d(omega_d), integrated over
        the box between neighbouring nodes. It weights a cell by how often uniformly
        drawn pairs of directions fall into it.
        """
        edge_h = _edges(self.theta_h)
        edge_d = _edges(self.theta_d)
        d_omega_h = -np.diff(np.cos(edge_h))
        # 4 cos sin d(theta_d) integrates to 2 sin^2
        d_omega_d = np.diff(np.sin(edge_d) ** 2)
        measure = d_omega_h[:, None, None] * d_omega_d[None, :, None] * self.above_horizon
        return frozen(measure / measure.sum())

    def half_diff(self, flat: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return (theta_h, theta_d, phi_d), each shaped as `flat`, of flat cell indices."""
        i, j, k = np.unravel_index(flat, self.shape)
        return self.theta_h[i], self.theta_d[j], self.phi_d[k]

    def directions(self, flat: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return (wi, wo), each (n, 3), of flat cell indices (n,)."""
        return directions_from_half_diff(*self.half_diff(flat))

    def position(
        self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return fractional node positions (i, j, k); the inverse of the node formulas.

        i and j are not clipped; k is in [0, n_phi_d) after reciprocity.
        """
        i = self.n_theta_h * np.sqrt(np.clip(theta_h, 0.0, None) / (np.pi / 2))
        j = self.n_theta_d * np.asarray(theta_d) / (np.pi / 2)
        k = self.n_phi_d * wrap_phi_d(phi_d) / np.pi
        return i, j, k

    def nearest(self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> IntArray:
        """Return the flat index of the nearest node (in index space) to each point."""
        i, j, k = self.position(theta_h, theta_d, phi_d)
        i_near = np.clip(np.rint(i), 0, self.n_theta_h - 1).astype(np.int64)
        j_near = np.clip(np.rint(j), 0, self.n_theta_d - 1).astype(np.int64)
        k_near = np.rint(k).astype(np.int64) % self.n_phi_d
        return np.asarray((i_near * self.n_theta_d + j_near) * self.n_phi_d + k_near)

    def linear(self, other: Grid) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return what carries values at the nodes to those of another grid, along each axis.

        Matrices (nodes of the other, nodes) of the interpolation that `corners` describes,
        which is their product.
        """
        i, j, k = self.position(other.theta_h, other.theta_d, other.phi_d)
        k0 = np.floor(k).astype(np.int64)
        axes = (_split(i, self.n_theta_h), _split(j, self.n_theta_d), (k0, k - k0))
        found = []
        for size, (low, share) in zip(self.shape, axes, strict=True):
            matrix, at = np.zeros((len(low), size)), np.arange(len(low))
            matrix[at, low % size] = 1.0 - share
            matrix[at, (low + 1) % size] += share
            found.append(matrix)
        return found[0], found[1], found[2]

    def corners(
        self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Return (flat indices, weights), each (n, 8), of trilinear interpolation.

        Linear in the warped node positions, periodic across the phi_d seam, constant
        beyond the last theta_h and theta_d node. Weights are >= 0 and sum to 1.
        """
        i, j, k = self.position(*(np.ravel(angle) for angle in (theta_h, theta_d, phi_d)))
        i0, u = _split(i, self.n_theta_h)
        j0, v = _split(j, self.n_theta_d)
        k0 = np.floor(k).astype(np.int64)
        w = k - k0
        index = np.empty((i0.size, 8), dtype=np.int64)
        weight = np.empty((i0.size, 8))
        for corner in range(8):
            a, b, c = corner >> 2 & 1, corner >> 1 & 1, corner & 1
            row = (i0 + a) * self.n_theta_d + (j0 + b)
            index[:, corner] = row * self.n_phi_d + (k0 + c) % self.n_phi_d
            weight[:, corner] = (u if a else 1 - u) * (v if b else 1 - v) * (w if c else 1 - w)
        return index, weight


def _split(position: FloatArray, n: int) -> tuple[IntArray, FloatArray]:
    clipped = np.clip(position, 0.0, n - 1)
    floor = np.minimum(np.floor(clipped).astype(np.int64), n - 2)
    return floor, np.asarray(clipped - floor)


def _edges(nodes: FloatArray) -> FloatArray:
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    return np.concatenate([[0.0], middle, [np.pi / 2]])


MERL_GRID = Grid()
"""The 90 x 90 x 180 grid of the MERL database."""
