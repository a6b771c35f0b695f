"""The local residual: a smooth Gaussian process in warped half/difference coordinates.

    u = (theta_h / (pi/2))^(1/3),    v = theta_d / (pi/2)

    k(x, x') = a^2 sum_h c_h  g_h(u) g_h(u') k_u(u, u')  g_h(v) g_h(v') k_v(v, v')  t_h t_h'

with t_h the functions cos 2h phi_d and sin 2h phi_d (periodic in pi, so that reciprocity
holds), k_u and k_v Matern kernels of smoothness 3/2, c_h falling with h, and g_h zero at the
poles for h > 0, where phi_d has no meaning. The cube root gives a specular lobe more room
than the square root of the MERL grid does.

The kernel is a sum of products, so its eigenfunctions are products of those along the axes:

    k(x, x') ~ sum_k psi_k(x) psi_k(x'),   psi_abh = e_a(u) e_b(v) t_h(phi_d)

cut off after the largest. That is what makes the dense result cheap: on a grid it is one small
product along each axis, whatever the number of samples.

Reference: C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT
Press 2006, sections 4.2.1 (Matern) and 4.3 (eigenfunctions).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from brdfit.arrays import FloatArray, IntArray

__all__ = ["LocalResidual", "Scale"]

# Nodes along u and v between which eigenfunctions are interpolated.
_NODES = 256
_HARMONICS = 4
_DECAY = 0.5
# A surface without a sense of rotation has no sine terms; decoded networks have small ones.
_SINE = 0.3
_POWER = 1.0 / 3.0

Angles = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True)
class Scale:
    """Length scales along u and v, and how many functions are kept."""

    along_u: float = 0.2
    along_v: float = 0.3
    size: int = 600


@dataclass(frozen=True, eq=False)
class _Harmonic:
    """The functions of one t_h: those along the axes, and which pairs are kept."""

    order: int
    sine: bool
    u: FloatArray
    v: FloatArray
    pairs: IntArray

    def around(self, phi_d: FloatArray) -> FloatArray:
        turn = 2 * self.order * np.asarray(phi_d)
        return np.sin(turn) if self.sine else np.cos(turn)


@dataclass(frozen=True, eq=False)
class LocalResidual:
    """The functions psi_k of unit amplitude, for one choice of length scales."""

    scale: Scale
    harmonics: tuple[_Harmonic, ...]

    @classmethod
    def of(cls, scale: Scale) -> LocalResidual:
        """Return the functions; computed once for each scale."""
        return _functions(scale)

    @property
    def size(self) -> int:
        """Number of functions."""
        return sum(len(h.pairs) for h in self.harmonics)

    def at(self, angles: Angles) -> FloatArray:
        """Return psi (n, size) at (theta_h, theta_d, phi_d), each (n,), radians."""
        u, v = _warped(*angles[:2])
        parts = []
        for h in self.harmonics:
            along_u = _interpolated(h.u, u)[:, h.pairs[:, 0]]
            along_v = _interpolated(h.v, v)[:, h.pairs[:, 1]]
            parts.append(along_u * along_v * h.around(angles[2])[:, None])
        return np.concatenate(parts, axis=1)

    def on_axes(
        self, coefficients: FloatArray, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
    ) -> FloatArray:
        """Return sum_k psi_k z_k on the grid of three axes, (h, d, phi, c), for z (size, c)."""
        u, v = _warped(theta_h, theta_d)
        total = np.zeros((u.size, v.size, phi_d.size, coefficients.shape[1]), dtype=np.float32)
        start = 0
        for h in self.harmonics:
            z = coefficients[start : start + len(h.pairs)]
            start += len(h.pairs)
            table = np.zeros((h.u.shape[1], h.v.shape[1], z.shape[1]))
            table[h.pairs[:, 0], h.pairs[:, 1]] = z
            plane = np.einsum(
                "ia,abc,jb->ijc", _interpolated(h.u, u), table, _interpolated(h.v, v), optimize=True
            ).astype(np.float32)
            around = h.around(phi_d).astype(np.float32)
            total += plane[:, :, None, :] * around[None, None, :, None]
        return total


def _warped(theta_h: FloatArray, theta_d: FloatArray) -> tuple[FloatArray, FloatArray]:
    quarter = np.pi / 2
    u = np.clip(np.asarray(theta_h) / quarter, 0.0, 1.0) ** _POWER
    return u, np.clip(np.asarray(theta_d) / quarter, 0.0, 1.0)


def _interpolated(nodes: FloatArray, position: FloatArray) -> FloatArray:
    """Return functions (n, k), known at `_NODES` nodes of [0, 1], at positions (n,)."""
    at = position * (_NODES - 1)
    low = np.minimum(at.astype(np.int64), _NODES - 2)
    share = (at - low)[:, None]
    return np.asarray(nodes[low] * (1.0 - share) + nodes[low + 1] * share)


@lru_cache(maxsize=8)
def _functions(scale: Scale) -> LocalResidual:
    x = np.linspace(0.0, 1.0, _NODES)
    # The half vector's pole is left soon (u is stretched there), that of theta_d like a sine.
    fade_u = np.minimum(np.sin(x**3 * np.pi / 2) / 0.3, 1.0)
    fade_v = np.sin(x * np.pi / 2)
    flat = (
        _eigenfunctions(scale.along_u, np.ones(_NODES)),
        _eigenfunctions(scale.along_v, np.ones(_NODES)),
    )
    faded = _eigenfunctions(scale.along_u, fade_u), _eigenfunctions(scale.along_v, fade_v)
    kinds = [(0, False), *((h, sine) for h in range(1, _HARMONICS + 1) for sine in (False, True))]
    share = [_DECAY**order * (_SINE if sine else 1.0) for order, sine in kinds]
    axes = [flat if order == 0 else faded for order, _ in kinds]
    size = [c * np.outer(u[0], v[0]) for c, (u, v) in zip(share, axes, strict=True)]
    least = np.sort(np.concatenate([s.ravel() for s in size]))[::-1][scale.size]
    found = []
    for (order, sine), c, (u, v), s in zip(kinds, share, axes, size, strict=True):
        pairs = np.argwhere(s > least)
        if len(pairs):
            used_u, used_v = pairs.max(axis=0) + 1
            along_u = np.sqrt(c) * u[1][:, :used_u]
            found.append(_Harmonic(order, sine, along_u, v[1][:, :used_v], pairs))
    return LocalResidual(scale, tuple(found))


def _eigenfunctions(length: float, fade: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (eigenvalues, functions at the nodes) of a faded Matern kernel, largest first.

    The functions are scaled so that their squares sum to the kernel's diagonal.
    """
    x = np.linspace(0.0, 1.0, _NODES)
    r = np.sqrt(3.0) * np.abs(x[:, None] - x) / length
    kernel = fade[:, None] * (1.0 + r) * np.exp(-r) * fade
    values, vectors = np.linalg.eigh(kernel)
    values = np.clip(values[::-1], 0.0, None)
    return values / _NODES, vectors[:, ::-1] * np.sqrt(values)
