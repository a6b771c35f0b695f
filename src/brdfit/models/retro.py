"""A lobe that returns light to where it came from: road signs, glass beads, rough matter.

    f(wi, wo) = F D G2 / (4 cos_i cos_o)    of wi and of wo mirrored at the normal

A GGX lobe (see `ggx`) about the back vector instead of the half vector, with Schlick's F.

References: L. Belcour, R. Pacanowski, M. Delahaie, A. Laville-Geay, L. Eupherte, "BRDF
measurements and analysis of retroreflecting materials", J. Opt. Soc. Am. A 31(12), 2014;
J. Portsmouth, M. Raab, L. Belcour, F. Liu, "The Minimal Retroreflective Microfacet Model",
JCGT 15(1), 2026.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns
from brdfit.models.facets import FacetAngles
from brdfit.models.fresnel import schlick
from brdfit.models.ggx import GgxLobe

__all__ = ["Retro"]


@dataclass(frozen=True, eq=False)
class Retro:
    """Parameters (columns,)."""

    f0: npt.ArrayLike
    """Strength at the peak, as a reflectance at normal incidence, [0, 1]."""
    alpha: npt.ArrayLike
    """Roughness of the lobe, (0, 1]."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        facets = FacetAngles.mirrored(angles)
        value = GgxLobe(self.alpha).at(facets)
        value *= schlick(facets.cos_d, np.asarray(self.f0))
        return value
