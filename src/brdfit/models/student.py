"""A microfacet lobe whose tail is a parameter: from Beckmann's, with none, to beyond GGX's.

    f(wi, wo) = F D G2 / (4 cos_i cos_o)

    D = (1 + tan^2(theta_h) / ((g - 1) a^2))^-g / (pi a^2 cos^4(theta_h))
    F = f0 + (1 - f0) (1 - wi . wh)^5

Slopes follow Student's t-distribution: g = 2 is GGX, g -> infinity Beckmann, and near 1 the
haze about the highlight is wide. G2 is that of GGX with the same roughness (see `ggx`), whatever
the tail: the distribution's own has no closed form. With g >= 2 it masks enough; with a longer
tail it masks too little at grazing, where a white surface then returns more than it receives
(g = 1.5: 1.28 times at 85 degrees).

Reference: M. Ribardiere, B. Bringier, D. Meneveaux, L. Simonot, "STD: Student's t-Distribution
of Slopes for Microfacet Based BSDFs", Computer Graphics Forum 36(2), 2017.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns
from brdfit.models.facets import FacetAngles
from brdfit.models.fresnel import schlick
from brdfit.models.ggx import GgxLobe

__all__ = ["Student"]


@dataclass(frozen=True, eq=False)
class Student:
    """Parameters (columns,)."""

    f0: npt.ArrayLike
    """Fresnel reflectance at normal incidence, [0, 1]."""
    alpha: npt.ArrayLike
    """Roughness, (0, 1]."""
    tail: npt.ArrayLike = 2.0
    """g, > 1: small is a long tail."""

    def __post_init__(self) -> None:
        freeze_columns(self)
        GgxLobe(self.alpha)  # says what is wrong with it
        if np.any(np.asarray(self.tail) <= 1.0):
            raise UsageError(
                f"Student: tail is {np.min(self.tail):g} but must be above 1, where the lobe holds "
                f"no more light than it has."
            )

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        facets = FacetAngles.outside(angles)
        a2, tail = np.asarray(self.alpha) ** 2, np.asarray(self.tail)
        value = GgxLobe(self.alpha).at(facets)
        value *= schlick(facets.cos_d, np.asarray(self.f0))
        # D over that of GGX: (1 + t/((g-1) a^2))^-g (1 + t/a^2)^2, in the logarithm
        squared = facets.tan2_h / a2
        exponent = 2.0 * np.log1p(squared)
        exponent -= tail * np.log1p(squared / (tail - 1.0))
        value *= np.exp(exponent)
        return value
