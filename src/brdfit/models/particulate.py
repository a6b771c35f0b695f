"""A surface of particles: powder, dust, unbound pigment, rough matter that is no set of facets.

    f(wi, wo) = w / (4 pi (cos_i + cos_o)) [(1 + B(g)) p(g) + H(cos_i) H(cos_o) - 1]

    cos g = wi . wo                                      g = 0 toward the light
    p(g)  = (1 - b^2) / (1 + 2 b cos g + b^2)^(3/2)      b > 0 scatters forward, b < 0 back
    B(g)  = surge / (1 + tan(g/2) / width)               particles hide their own shadows
    H(x)  = (1 + 2 x) / (1 + 2 x sqrt(1 - w))            light scattered more than once

Reference: B. Hapke, "Bidirectional Reflectance Spectroscopy 1. Theory", Journal of Geophysical
Research 86(B4), 1981; the phase function is that of L. Henyey and J. Greenstein, "Diffuse
Radiation in the Galaxy", Astrophysical Journal 93, 1941.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns

__all__ = ["Particulate"]


@dataclass(frozen=True, eq=False)
class Particulate:
    """Parameters (columns,)."""

    scattering: npt.ArrayLike
    """w, what a particle scatters of what it takes from the beam, (0, 1]."""
    asymmetry: npt.ArrayLike = 0.0
    """b, mean cosine of the scattering angle, (-1, 1)."""
    surge: npt.ArrayLike = 0.0
    """Height of the opposition surge, [0, 1]."""
    width: npt.ArrayLike = 0.1
    """Its width, > 0: the tangent of half the angle at which it has fallen to a half."""

    def __post_init__(self) -> None:
        freeze_columns(self)
        if np.any(np.abs(self.asymmetry) >= 1.0) or np.any(np.asarray(self.width) <= 0.0):
            raise UsageError(
                f"Particulate: found asymmetry up to {np.max(np.abs(self.asymmetry)):g} and width "
                f"down to {np.min(self.width):g}, but |asymmetry| is below 1 and width above 0."
            )

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        w, b = np.asarray(self.scattering), np.asarray(self.asymmetry)
        # theta_d is half of g
        along = 2.0 * angles.cos_d**2 - 1.0
        tangent = np.sqrt(1.0 - angles.cos_d**2) / np.maximum(angles.cos_d, 1e-9)
        value = (1.0 - b**2) * (1.0 + 2.0 * b * along + b**2) ** -1.5
        value *= 1.0 + np.asarray(self.surge) / (1.0 + tangent / np.asarray(self.width))
        absorbing = np.sqrt(1.0 - w)
        value += _often(angles.cos_i, absorbing) * _often(angles.cos_o, absorbing) - 1.0
        value *= w / (4.0 * np.pi) / (angles.cos_i + angles.cos_o)
        return np.asarray(value)


def _often(cosine: FloatArray, absorbing: FloatArray) -> FloatArray:
    return np.asarray((1.0 + 2.0 * cosine) / (1.0 + 2.0 * cosine * absorbing))
