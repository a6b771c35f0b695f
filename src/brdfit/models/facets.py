"""What a microfacet lobe needs to know of two directions, seen from where its facets are.

The same lobe describes a rough surface, a retro-reflector and flakes in a clear coat: what
differs is the pair of directions that its facets see.

    FacetAngles.outside(angles)         the directions as they are
    FacetAngles.mirrored(angles)        wo mirrored at the normal: the lobe looks back at the light
    FacetAngles.inside(angles, ior)     both refracted into a coat of that index

All are symmetric in the two directions, so that whatever is built on them is reciprocal.

References: L. Belcour, R. Pacanowski, M. Delahaie, A. Laville-Geay, L. Eupherte, "BRDF
measurements and analysis of retroreflecting materials", J. Opt. Soc. Am. A 31(12), 2014 (the
back vector); J. Portsmouth, M. Raab, L. Belcour, F. Liu, "The Minimal Retroreflective
Microfacet Model", JCGT 15(1), 2026 (one mirrored direction in any microfacet model).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles

__all__ = ["FacetAngles"]

# Two directions along the horizon and opposite to each other have no half vector.
_SMALLEST = 1e-12


@dataclass(frozen=True, eq=False)
class FacetAngles:
    """Cosines (n, 1) or (n, columns) of n pairs of directions.

    | name             | meaning                                    |
    |------------------|--------------------------------------------|
    | `cos_i`, `cos_o` | to the normal, above 0                     |
    | `tan2_h`         | tan^2 between the half vector and the normal |
    | `cos_d`          | between a direction and the half vector    |
    """

    cos_i: FloatArray
    cos_o: FloatArray
    tan2_h: FloatArray
    cos_d: FloatArray

    @classmethod
    def outside(cls, angles: PairAngles) -> FacetAngles:
        """Return the angles of the directions themselves."""
        return cls(angles.cos_i, angles.cos_o, angles.tan2_h, angles.cos_d)

    @classmethod
    def mirrored(cls, angles: PairAngles) -> FacetAngles:
        """Return the angles of wi and of wo turned by half a turn about the normal."""
        # wi . wo' = 2 cos_i cos_o - wi . wo
        along = 2.0 * angles.cos_i * angles.cos_o - _along(angles)
        return cls._of(angles.cos_i, angles.cos_o, along)

    @classmethod
    def inside(cls, angles: PairAngles, ior: FloatArray) -> FacetAngles:
        """Return the angles after refraction into a medium of index `ior` (columns,) >= 1."""
        cos_i = np.sqrt(1.0 - (1.0 - angles.cos_i**2) / ior**2)
        cos_o = np.sqrt(1.0 - (1.0 - angles.cos_o**2) / ior**2)
        tangential = (_along(angles) - angles.cos_i * angles.cos_o) / ior**2
        return cls._of(cos_i, cos_o, tangential + cos_i * cos_o)

    @classmethod
    def _of(cls, cos_i: FloatArray, cos_o: FloatArray, along: FloatArray) -> FacetAngles:
        # |wi + wo|^2 = 2 + 2 wi . wo = 4 cos_d^2,   cos_h = (cos_i + cos_o) / |wi + wo|
        cos2_d = np.clip(0.5 * (1.0 + along), _SMALLEST, 1.0)
        cos2_h = np.clip((cos_i + cos_o) ** 2 / (4.0 * cos2_d), _SMALLEST, 1.0)
        return cls(cos_i, cos_o, (1.0 - cos2_h) / cos2_h, np.sqrt(cos2_d))


def _along(angles: PairAngles) -> FloatArray:
    """Return wi . wo."""
    return np.asarray(2.0 * angles.cos_d**2 - 1.0)
