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

__all__ = ["Ggx"]


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
        if np.any(np.asarray(self.alpha) <= 0.0):
            raise UsageError(
                f"Ggx: alpha is {np.min(self.alpha):g} but must be above 0; a mirror has no f_r."
            )

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        f0, a2 = np.asarray(self.f0), np.asarray(self.alpha) ** 2
        # cos^2 (a^2 - 1) + 1 = a^2 cos^2 + sin^2, which does not cancel at the peak
        cos2_h = angles.cos_h**2
        sin2_h = angles.tan2_h * cos2_h
        distribution = a2 / (np.pi * (a2 * cos2_h + sin2_h) ** 2)
        masked_i = angles.cos_o * np.sqrt(a2 + (1.0 - a2) * angles.cos_i**2)
        masked_o = angles.cos_i * np.sqrt(a2 + (1.0 - a2) * angles.cos_o**2)
        fresnel = f0 + (1.0 - f0) * (1.0 - angles.cos_d) ** 5
        # G2 / (4 cos_i cos_o) = 1 / (2 (masked_i + masked_o))
        value = np.asarray(self.diffuse) / np.pi + fresnel * distribution * 0.5 / (
            masked_i + masked_o
        )
        return np.where(angles.above, value, 0.0)
