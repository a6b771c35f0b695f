"""An isotropic GGX microfacet lobe over a Lambertian base: synthetic materials.

    f(wi, wo) = diffuse / pi + F D G2 / (4 cos_i cos_o)

    D  = a^2 / (pi (cos^2 theta_h (a^2 - 1) + 1)^2)
    G2 = 2 cos_i cos_o / (cos_o sqrt(a^2 + (1 - a^2) cos_i^2) + cos_i sqrt(a^2 + (1 - a^2) cos_o^2))
    F  = f0 + (1 - f0) (1 - wi . wh)^5

References: B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
EGSR 2007 (D); E. Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based
BRDFs", JCGT 3(2), 2014 (height-correlated G2); C. Schlick, "An Inexpensive BRDF Model for
Physically-based Rendering", Computer Graphics Forum 13(3), 1994 (F).
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

__all__ = ["Ggx", "GgxLobe"]


@dataclass(frozen=True, eq=False)
class GgxLobe:
    """The lobe of facets that reflect everything: D G2 / (4 cos_i cos_o)."""

    alpha: npt.ArrayLike
    """Roughness of the distribution (not its square root), (0, 1]."""

    def __post_init__(self) -> None:
        freeze_columns(self)
        if np.any(np.asarray(self.alpha) <= 0.0):
            raise UsageError(
                f"Ggx: alpha is {np.min(self.alpha):g} but must be above 0; a mirror has no f_r."
            )

    def at(self, facets: FacetAngles) -> FloatArray:
        """Return D G2 / (4 cos_i cos_o), (n, columns) in 1/sr."""
        a2 = np.asarray(self.alpha) ** 2
        cos2_h = 1.0 / (1.0 + facets.tan2_h)
        # cos^2 (a^2 - 1) + 1 = a^2 cos^2 + sin^2, which does not cancel at the peak
        sin2_h = facets.tan2_h * cos2_h
        distribution = a2 / (np.pi * (a2 * cos2_h + sin2_h) ** 2)
        masked_i = facets.cos_o * np.sqrt(a2 + (1.0 - a2) * facets.cos_i**2)
        masked_o = facets.cos_i * np.sqrt(a2 + (1.0 - a2) * facets.cos_o**2)
        # G2 / (4 cos_i cos_o) = 1 / (2 (masked_i + masked_o))
        return np.asarray(distribution * 0.5 / (masked_i + masked_o))


@dataclass(frozen=True, eq=False)
class Ggx:
    """Parameters (channels,); a single value holds for all channels."""

    diffuse: npt.ArrayLike = 0.2
    """Albedo of the Lambertian base, [0, 1]."""
    f0: npt.ArrayLike = 0.04
    """Fresnel reflectance at normal incidence, [0, 1]."""
    alpha: npt.ArrayLike = 0.2
    """Roughness of the distribution (not its square root), (0, 1]."""

    def __post_init__(self) -> None:
        freeze_columns(self)
        GgxLobe(self.alpha)  # says what is wrong with it

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, channels), as if every direction were above the horizon."""
        value = GgxLobe(self.alpha).at(FacetAngles.outside(angles))
        value *= schlick(angles.cos_d, np.asarray(self.f0))
        value += np.asarray(self.diffuse) / np.pi
        return value
