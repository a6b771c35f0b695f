"""A smooth function on a lattice over the unit box whose last axis is periodic.

    q(x) = sum_ijk beta_3(n0 x_0 - i) beta_3(n1 x_1 - j) beta_3(n2 x_2 - k) c_ijk

cubic B-splines that pass through the values at the nodes, with mirrored ends. Scattered points
and products of axes read the same function.

Reference: M. Unser, "Splines: a perfect fit for signal and image processing", IEEE Signal
Processing Magazine 16(6), 1999, 22-38.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["Lattice", "node_positions"]

# Coefficients on either side of the nodes, so that every point has all it needs.
_MARGIN = 2


def node_positions(shape: tuple[int, int, int]) -> FloatArray:
    """Return the nodes (n, 3) of a lattice of `shape`, in [0, 1]^2 x [0, 1), the last fastest."""
    axes = [np.linspace(0.0, 1.0, shape[0]), np.linspace(0.0, 1.0, shape[1])]
    axes.append(np.arange(shape[2]) / shape[2])
    return np.stack([a.ravel() for a in np.meshgrid(*axes, indexing="ij")], axis=1)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Spline coefficients (n0 + 4, n1 + 4, n2 + 4, c), float32."""

    coefficients: FloatArray

    @classmethod
    def through(cls, values: FloatArray) -> Lattice:
        """Return the function with `values` (n0, n1, n2, c) at the nodes; n0, n1, n2 >= 4."""
        from scipy.ndimage import spline_filter1d

        found = np.asarray(values, dtype=np.float64)
        for axis, mode in enumerate(("mirror", "mirror", "grid-wrap")):
            found = spline_filter1d(found, 3, axis=axis, mode=mode)
        ends = [(_MARGIN, _MARGIN), (_MARGIN, _MARGIN), (0, 0), (0, 0)]
        found = np.pad(found, ends, mode="reflect")
        around = [(0, 0), (0, 0), (_MARGIN, _MARGIN), (0, 0)]
        return cls(np.pad(found, around, mode="wrap").astype(np.float32))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Nodes along each axis."""
        n0, n1, n2 = (n - 2 * _MARGIN for n in self.coefficients.shape[:3])
        return n0, n1, n2

    def at(self, x: FloatArray) -> FloatArray:
        """Return q (n, c), float64, at points (n, 3); those outside the box are moved to it."""
        from scipy.ndimage import map_coordinates

        places = np.stack([self._place(x[:, axis], axis) for axis in range(3)])
        channels = np.moveaxis(self.coefficients, -1, 0)
        read = [
            map_coordinates(one, places, output=np.float64, order=3, prefilter=False)
            for one in channels
        ]
        return np.stack(read, axis=1) if read else np.empty((len(x), 0))

    def matrices(self, *axes: FloatArray) -> list[FloatArray]:
        """Return what carries the coefficients along each axis to places on it.

        Matrices (places, n + 4), float32; q at all combinations of places is their product.
        """
        return [
            _basis(self._place(x, axis), self.coefficients.shape[axis])
            for axis, x in enumerate(axes)
        ]

    def _place(self, x: FloatArray, axis: int) -> FloatArray:
        """Return where x is among the coefficients of an axis."""
        n = self.shape[axis]
        inside = np.mod(x, 1.0) * n if axis == 2 else np.clip(x, 0.0, 1.0) * (n - 1)
        return np.asarray(inside + _MARGIN)


def _basis(place: FloatArray, size: int) -> FloatArray:
    """Return beta_3(place - i) (len(place), size), float32."""
    t = np.abs(place[:, None] - np.arange(size))
    near, far = 2.0 / 3.0 - t**2 + t**3 / 2.0, (2.0 - t) ** 3 / 6.0
    return np.where(t < 1.0, near, np.where(t < 2.0, far, 0.0)).astype(np.float32)
