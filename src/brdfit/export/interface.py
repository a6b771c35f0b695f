"""The pieces that the targets' materials share: a GGX lobe in all channels, an interface.

lobe(wi, wo) = D(theta_h) G2(wi, wo) / (4 cos_i cos_o)      see brdfit.models.ggx
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models import PairAngles
from brdfit.models.facets import FacetAngles
from brdfit.models.fresnel import dielectric
from brdfit.models.ggx import GgxLobe

__all__ = ["dielectric_fresnel", "f0_of_ior", "ggx_lobe", "ior_of_f0", "schlick"]


def ggx_lobe(angles: PairAngles, alpha: float) -> FloatArray:
    """Return D G2 / (4 cos_i cos_o), (n, 1), of roughness `alpha`, (0, 1]."""
    return GgxLobe(alpha).at(FacetAngles.outside(angles))


def schlick(cosine: FloatArray, f0: npt.ArrayLike, f90: float = 1.0) -> FloatArray:
    """Return f0 + (f90 - f0) (1 - cosine)^5: from normal incidence to grazing."""
    f0 = np.asarray(f0)
    return np.asarray(f0 + (f90 - f0) * (1.0 - cosine) ** 5)


def dielectric_fresnel(cosine: FloatArray, ior: float) -> FloatArray:
    """Return the unpolarised reflectance of a dielectric of relative index `ior` >= 1."""
    return dielectric(cosine, np.asarray(ior))


def f0_of_ior(ior: float) -> float:
    """Return the reflectance at normal incidence of a dielectric in air."""
    return float(((ior - 1.0) / (ior + 1.0)) ** 2)


def ior_of_f0(f0: float) -> float:
    """Return the index of refraction, >= 1, of a dielectric that reflects `f0` in [0, 1)."""
    root = np.sqrt(f0)
    return float((1.0 + root) / (1.0 - root))
