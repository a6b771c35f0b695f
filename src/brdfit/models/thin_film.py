"""A rough surface under a thin film: the colour of the lobe turns with the angle.

    f(wi, wo) = R(wi . wh) D G2 / (4 cos_i cos_o)

with the GGX lobe (see `ggx`) and R the reflectance of a film on a base, averaged over the
band of the channel (see `fresnel`). Oxides on metal, soap, oil, "colour-changing" foils.

Reference: L. Belcour, P. Barla, "A Practical Extension to Microfacet Theory for the Modeling
of Varying Iridescence", ACM Transactions on Graphics 36(4), 2017. Theirs integrates over the
colour-matching functions in closed form and cuts Airy's sum after a few reflections; here the
whole sum is averaged over a band, which can be neither negative nor above 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns
from brdfit.models.facets import FacetAngles
from brdfit.models.fresnel import film
from brdfit.models.ggx import GgxLobe

__all__ = ["ThinFilm"]


@dataclass(frozen=True, eq=False)
class ThinFilm:
    """Parameters (columns,); a column is a channel, and has a wavelength of its own."""

    alpha: npt.ArrayLike
    """Roughness of the lobe, (0, 1]."""
    thickness: npt.ArrayLike
    """Of the film, nm, >= 0."""
    wavelength: npt.ArrayLike
    """Middle of the channel's band, nm."""
    ior: npt.ArrayLike = 1.5
    """Index of the film, >= 1."""
    base: npt.ArrayLike = 1.5
    """Index of what the film lies on, > 0."""
    extinction: npt.ArrayLike = 0.0
    """Extinction of what it lies on (k of a metal), >= 0."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        figures = (self.thickness, self.ior, self.base, self.extinction, self.wavelength)
        value = film(angles.cos_d, *(np.asarray(figure) for figure in figures))
        value *= GgxLobe(self.alpha).at(FacetAngles.outside(angles))
        return value
