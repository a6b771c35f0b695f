"""Warping the unit square by a density, and back.

A density p on the unit square is given at ny x nx nodes (rows y, columns x, both ends
included) and is bilinear in between. The warp sends the uniform unit square to p: first y
by its marginal, then x by its conditional,

    s_y = M(y) = int_0^y m,             m(y) = int_0^1 p(x, y) dx
    s_x = C(x | y) = int_0^x p(x', y) dx' / m(y)

m and p(., y) are linear between nodes, so M and C are quadratic there, and inverting them
is solving a quadratic equation. One density is kept for each value of a parameter (the
incidence angle). Between two of them p is linear in the parameter, and so are m, M and the
numerator of C; the normalised densities are what is mixed.

Reference: J. Dupuy and W. Jakob, "An Adaptive Parameterization for Efficient Material
Acquisition and Rendering", ACM Trans. Graph. 37(6), 2018, section 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray

__all__ = ["Warp", "bilinear", "split"]


@dataclass(frozen=True)
class Warp:
    """Densities with their integrals; build it with `Warp.of`."""

    density: FloatArray
    """p, (parameters, ny, nx), each integrating to 1."""
    along_x: FloatArray
    """int_0^x p dx at the nodes, (parameters, ny, nx)."""
    along_y: FloatArray
    """M at the nodes, (parameters, ny)."""

    @classmethod
    def of(cls, density: FloatArray) -> Warp:
        """Return the warp of densities (parameters, ny, nx) >= 0, each with a mass > 0."""
        density = np.asarray(density, dtype=np.float64)
        mass = _running_integral(_running_integral(density)[:, :, -1])[:, -1]
        density = density / mass[:, None, None]
        along_x = _running_integral(density)
        return cls(density, along_x, _running_integral(along_x[:, :, -1]))

    def forward(self, parameter: int, s_x: FloatArray, s_y: FloatArray) -> FloatArray:
        """Return where the lattice s_x (k,), s_y (l,) goes, (l, k, 2) as (x, y).

        Where the density vanishes on an interval, its lower end is returned.
        """
        marginal = self.along_x[parameter, :, -1]
        j, v = _invert(marginal[None], self.along_y[parameter][None], s_y[None])
        row, v = j[0], v[0][:, None]
        density = self.density[parameter]
        conditional = (1.0 - v) * density[row] + v * density[row + 1]
        running = _running_integral(conditional)
        i, u = _invert(conditional, running, s_x * running[:, -1:])
        x = (i + u) / (density.shape[1] - 1)
        y = (row[:, None] + v) / (density.shape[0] - 1)
        return np.stack(np.broadcast_arrays(x, y), axis=-1)

    def inverse(
        self, index: IntArray, fraction: FloatArray, x: FloatArray, y: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return (s_x, s_y), each (n,), of points (x, y) in the unit square.

        The density is mixed between the parameters `index` and `index + 1` with weights
        1 - `fraction` and `fraction`, each (n,). Where it is zero s_x is 0.
        """
        ny, nx = self.density.shape[1:]
        i, u = split(x, nx)
        j, v = split(y, ny)
        below, above = np.zeros_like(u), np.zeros_like(u)
        m_below, m_above, s_y = np.zeros_like(u), np.zeros_like(u), np.zeros_like(u)
        for slice_, share in ((index, 1.0 - fraction), (index + 1, fraction)):
            below += share * self._integral_to(slice_, j, i, u)
            above += share * self._integral_to(slice_, j + 1, i, u)
            m_below += share * self.along_x[slice_, j, -1]
            m_above += share * self.along_x[slice_, j + 1, -1]
            s_y += share * self.along_y[slice_, j]
        s_y += (m_below * v + (m_above - m_below) * v * v / 2.0) / (ny - 1)
        marginal = (1.0 - v) * m_below + v * m_above
        up_to_x = (1.0 - v) * below + v * above
        s_x = np.where(marginal > 0.0, up_to_x / np.where(marginal > 0.0, marginal, 1.0), 0.0)
        return np.clip(s_x, 0.0, 1.0), np.clip(s_y, 0.0, 1.0)

    def _integral_to(
        self, slice_: IntArray, row: IntArray, i: IntArray, u: FloatArray
    ) -> FloatArray:
        # int_0^x p at one row of nodes; quadratic in u within the cell
        left, right = self.density[slice_, row, i], self.density[slice_, row, i + 1]
        within = (left * u + (right - left) * u * u / 2.0) / (self.density.shape[2] - 1)
        return np.asarray(self.along_x[slice_, row, i] + within)


def split(position: FloatArray, n: int) -> tuple[IntArray, FloatArray]:
    """Return (cell, fraction) of positions in [0, 1] among `n` >= 2 evenly spaced nodes."""
    scaled = np.clip(position, 0.0, 1.0) * (n - 1)
    cell = np.minimum(scaled.astype(np.int64), n - 2)
    return cell, np.asarray(scaled - cell)


def bilinear(nodes: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return `nodes` (ny, nx) at points (x, y) of the unit square, any shape."""
    i, u = split(x, nodes.shape[1])
    j, v = split(y, nodes.shape[0])
    low = (1.0 - u) * nodes[j, i] + u * nodes[j, i + 1]
    high = (1.0 - u) * nodes[j + 1, i] + u * nodes[j + 1, i + 1]
    return np.asarray((1.0 - v) * low + v * high)


def _running_integral(nodes: FloatArray) -> FloatArray:
    """Integrate over the last axis from 0 to each node; trapezoids are exact here."""
    step = 1.0 / (nodes.shape[-1] - 1)
    result = np.zeros_like(nodes)
    np.cumsum(0.5 * step * (nodes[..., 1:] + nodes[..., :-1]), axis=-1, out=result[..., 1:])
    return result


def _invert(
    nodes: FloatArray, running: FloatArray, target: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return (cell, fraction), (rows, k), where the running integral reaches `target`.

    Within a cell of width h from density a to b: h (a t + (b - a) t^2 / 2) = rest, whose
    root 2 r / (a + sqrt(a^2 + 2 (b - a) r)) with r = rest / h stays accurate for a = b.
    """
    n = nodes.shape[-1]
    first = [np.searchsorted(*pair) for pair in zip(running, target, strict=True)]
    cell = np.clip(np.asarray(first) - 1, 0, n - 2)
    a = np.take_along_axis(nodes, cell, axis=-1)
    b = np.take_along_axis(nodes, cell + 1, axis=-1)
    r = (target - np.take_along_axis(running, cell, axis=-1)) * (n - 1)
    denominator = a + np.sqrt(np.maximum(a * a + 2.0 * (b - a) * r, 0.0))
    t = 2.0 * r / np.where(denominator > 0.0, denominator, 1.0)
    return cell, np.clip(t, 0.0, 1.0)
