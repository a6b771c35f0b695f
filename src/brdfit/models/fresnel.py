"""How much a smooth interface reflects: dielectrics, Schlick's conductors, thin films.

Reflectances are of unpolarised light, in [0, 1], functions of the cosine between a direction
and the normal of the (micro)facet.

References: M. Born, E. Wolf, "Principles of Optics", 7th ed. 1999, section 1.6 (Airy's sum for
one homogeneous film); L. Belcour, P. Barla, "A Practical Extension to Microfacet Theory for
the Modeling of Varying Iridescence", ACM Transactions on Graphics 36(4), 2017 (a film on a
microfacet, and why a band must be integrated over); C. Schlick, "An Inexpensive BRDF Model
for Physically-based Rendering", Computer Graphics Forum 13(3), 1994.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from brdfit.arrays import FloatArray, frozen

__all__ = ["BAND_WIDTH", "dielectric", "film", "gauss_legendre", "schlick"]

BAND_WIDTH = 80.0
"""nm. Width of the band over which a film's reflectance is averaged: that of a colour primary.

A single wavelength would give fringes that no camera channel sees, and that no smooth prior
should believe in.
"""

# Gauss-Legendre nodes in a band: exact to 1e-3 for films up to 2 micrometres.
_NODES = 5


def dielectric(cosine: FloatArray, ior: FloatArray) -> FloatArray:
    """Return the reflectance of a dielectric of relative index `ior` >= 1, broadcast."""
    # g^2 = n^2 - 1 + c^2;  F = 1/2 ((g-c)/(g+c))^2 [1 + ((c(g+c)-1) / (c(g-c)+1))^2]
    g = np.sqrt(ior**2 - 1.0 + cosine**2)
    plus, minus = g + cosine, g - cosine
    parallel = (cosine * plus - 1.0) / (cosine * minus + 1.0)
    return np.asarray(0.5 * (minus / plus) ** 2 * (1.0 + parallel**2))


def schlick(cosine: FloatArray, f0: FloatArray) -> FloatArray:
    """Return f0 + (1 - f0) (1 - cosine)^5, broadcast: `f0` at normal incidence, 1 at grazing."""
    return np.asarray(f0 + (1.0 - f0) * (1.0 - cosine) ** 5)


def film(
    cosine: FloatArray,
    thickness: FloatArray,
    ior: FloatArray,
    base: FloatArray,
    extinction: FloatArray,
    wavelength: FloatArray,
) -> FloatArray:
    """Return the reflectance of a film of `thickness` (nm) on a base, averaged over a band.

    `ior` is that of the film, `base` and `extinction` are n and k of what it lies on, all
    relative to the medium that light comes from; `wavelength` (nm, in that medium) is the
    middle of the band. `cosine` (n, 1) or (n, columns), all others (columns,).
    """
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / ior**2)
    complex_base = base + 1j * extinction
    below = np.sqrt(1.0 - (1.0 - cosine**2) / complex_base**2)
    # amplitudes at the two interfaces, s and p
    top_s = (cosine - ior * inside) / (cosine + ior * inside)
    top_p = (ior * cosine - inside) / (ior * cosine + inside)
    bottom_s = (ior * inside - complex_base * below) / (ior * inside + complex_base * below)
    bottom_p = (complex_base * inside - ior * below) / (complex_base * inside + ior * below)
    path = 4.0 * np.pi * ior * thickness * inside
    waves = _Airy.of(top_s, bottom_s), _Airy.of(top_p, bottom_p)
    total = np.zeros(np.broadcast_shapes(path.shape, top_s.shape))
    for node, share in zip(*gauss_legendre(_NODES), strict=True):
        turn = path / (wavelength + 0.5 * BAND_WIDTH * node)
        cos, sin = np.cos(turn), np.sin(turn)
        for wave in waves:
            total += share / 4.0 * wave.at(cos, sin)
    return total


@dataclass(frozen=True, eq=False)
class _Airy:
    """|(r1 + r2 e^it) / (1 + r1 r2 e^it)|^2 with r1 real: all of it that t has no part in."""

    twice: FloatArray
    """2 r1"""
    real: FloatArray
    imag: FloatArray
    above: FloatArray
    """r1^2 + |r2|^2"""
    below: FloatArray
    """1 + r1^2 |r2|^2"""

    @classmethod
    def of(cls, top: FloatArray, bottom: FloatArray) -> _Airy:
        real, imag = np.ascontiguousarray(bottom.real), np.ascontiguousarray(bottom.imag)
        squared, top2 = real**2 + imag**2, top**2
        return cls(2.0 * top, real, imag, top2 + squared, 1.0 + top2 * squared)

    def at(self, cos: FloatArray, sin: FloatArray) -> FloatArray:
        """Return it at cos t, sin t."""
        cross = self.real * cos
        cross -= self.imag * sin
        cross *= self.twice
        return np.asarray((self.above + cross) / (self.below + cross))


@lru_cache(maxsize=8)
def gauss_legendre(count: int) -> tuple[FloatArray, FloatArray]:
    """Return (nodes, shares), (count,) each, of the quadrature over [-1, 1]."""
    nodes, shares = np.polynomial.legendre.leggauss(count)
    return frozen(nodes), frozen(shares)
