"""What lies under a smooth clear coat: a diffuse base, metallic flakes, pearlescent flakes.

Light enters through the coat, meets the base along refracted directions, and leaves again:

    f(wi, wo) = T(theta_i) T(theta_o) / n^2  f_inside(wi', wo')

T = 1 - F of a dielectric of index n; n^2 is what a beam widens on leaving. The reflection of the
coat itself is a lobe of its own, to be added.

- `CoatedDiffuse`: a Lambertian base; what the coat throws back is reflected again and again,
  f_inside = albedo / (pi (1 - albedo F_in)), F_in = 1 - (1 - F_out) / n^2 the diffuse
  reflectance from inside (Saunderson 1942).
- `Flakes`: many small tilted mirrors, as smooth as their mean: a GGX lobe of refracted
  directions with a tinted Schlick term. Flakes that are seen one by one are not a BRDF.
- `PearlFlakes`: the mirrors carry a thin film, as titania on mica does.

References: J. L. Saunderson, "Calculation of the Color of Pigmented Plastics", J. Opt. Soc. Am.
32(12), 1942; S. Ershov, K. Kolchin, K. Myszkowski, "Rendering Pearlescent Appearance Based on
Paint-Composition Modelling", Computer Graphics Forum 20(3), 2001; J. Guenther et al.,
"Efficient Acquisition and Realistic Rendering of Car Paint", VMV 2005.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns
from brdfit.models.facets import FacetAngles
from brdfit.models.fresnel import dielectric, film, gauss_legendre, schlick
from brdfit.models.ggx import GgxLobe

__all__ = ["CoatedDiffuse", "Flakes", "PearlFlakes"]


@dataclass(frozen=True, eq=False)
class CoatedDiffuse:
    """A diffuse base under a coat; parameters (columns,)."""

    albedo: npt.ArrayLike
    """Of the base, [0, 1]."""
    ior: npt.ArrayLike = 1.5
    """Index of the coat, >= 1."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        albedo, ior = np.asarray(self.albedo), np.asarray(self.ior)
        trapped = 1.0 - (1.0 - _diffuse_reflectance(ior)) / ior**2
        value = _transmission(angles, ior)
        value *= albedo / (np.pi * (1.0 - albedo * trapped))
        return value


@dataclass(frozen=True, eq=False)
class Flakes:
    """Metallic flakes under a coat; parameters (columns,)."""

    alpha: npt.ArrayLike
    """Spread of their tilt, as the roughness of a GGX lobe, (0, 1]."""
    f0: npt.ArrayLike
    """Share of the area times reflectance at normal incidence, [0, 1]."""
    ior: npt.ArrayLike = 1.5
    """Index of the coat, >= 1."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        ior = np.asarray(self.ior)
        facets = FacetAngles.inside(angles, ior)
        value = GgxLobe(self.alpha).at(facets)
        value *= schlick(facets.cos_d, np.asarray(self.f0))
        value *= _transmission(angles, ior)
        return value


@dataclass(frozen=True, eq=False)
class PearlFlakes:
    """Flakes with a thin film, under a coat; a column has a wavelength of its own."""

    alpha: npt.ArrayLike
    """Spread of their tilt, as the roughness of a GGX lobe, (0, 1]."""
    amount: npt.ArrayLike
    """Share of the area that they cover, [0, 1]."""
    thickness: npt.ArrayLike
    """Of the film, nm, >= 0."""
    wavelength: npt.ArrayLike
    """Middle of the channel's band in air, nm."""
    film_ior: npt.ArrayLike = 2.5
    """Index of the film, at least that of the coat (titania 2.5)."""
    base: npt.ArrayLike = 1.58
    """Index of the flake below the film (mica 1.58)."""
    extinction: npt.ArrayLike = 0.0
    """Extinction of the flake below the film, >= 0 (a metal core: several)."""
    ior: npt.ArrayLike = 1.5
    """Index of the coat, >= 1."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        ior = np.asarray(self.ior)
        facets = FacetAngles.inside(angles, ior)
        # as the light in the coat sees them: indices relative to it, wavelength shortened by it
        indices = (self.film_ior, self.base, self.extinction, self.wavelength)
        relative = (np.asarray(figure) / ior for figure in indices)
        value = film(facets.cos_d, np.asarray(self.thickness), *relative)
        value *= GgxLobe(self.alpha).at(facets)
        value *= np.asarray(self.amount) * _transmission(angles, ior)
        return value


def _transmission(angles: PairAngles, ior: FloatArray) -> FloatArray:
    """Return T(theta_i) T(theta_o) / n^2, (n, columns)."""
    entering = 1.0 - dielectric(angles.cos_i, ior)
    return np.asarray(entering * (1.0 - dielectric(angles.cos_o, ior)) / ior**2)


def _diffuse_reflectance(ior: FloatArray) -> FloatArray:
    """Return the reflectance of a coat for diffuse light from outside, (columns,)."""
    nodes, shares = gauss_legendre(64)
    cosine, share = (nodes[:, None] + 1.0) / 2.0, shares / 2.0
    return np.asarray(share @ (2.0 * cosine * dielectric(cosine, ior)))
