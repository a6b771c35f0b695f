"""What an analytic material is fitted to: rendered spheres as an eye compares them.

The perceptual error (mean CIEDE2000 on the studio sphere) has no slope where a screen clips,
and a lobe narrower than a pixel leaves few marks in a picture. So the residuals are

    sphere      CIELAB differences of the studio sphere's pixels, light above the screen's white
                compressed to 1 + ln x instead of clipped, chroma weighted down as in CIE94
    highlight   ln f differences on a fixed set of half and difference angles, dense around the
                specular peak, at a small weight: they decide what the picture leaves open
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray, IntArray
from brdfit.export.form import AnalyticMaterial
from brdfit.geometry import directions_from_half_diff
from brdfit.models import Ggx, PairAngles
from brdfit.render import Sphere, studio
from brdfit.tone import colour_library, exposure_scale

__all__ = ["Views"]

# A difference of ln f by 1 moves a middle grey by about this many units of CIELAB.
_LAB_OF_LN = 22.0
# Values below this many 1/sr are black to any eye.
_BLACK = 1e-3
_HIGHLIGHT_ANGLES = 28
_THETA_D = (4.0, 25.0, 45.0, 62.0, 76.0)
_HORIZON = 0.08
_ALPHAS = (0.01, 0.025, 0.06, 0.12, 0.25, 0.5, 0.9)


@dataclass(frozen=True, eq=False)
class Views:
    """Pairs of directions that are looked at, and what the reference shows there."""

    angles: PairAngles
    """Of the sphere's pairs, then of the highlight's."""
    pixel: IntArray
    """(pairs of the sphere,) which pixel."""
    light: FloatArray
    """(pairs of the sphere, 3) irradiance times cosine, times the exposure."""
    value: FloatArray
    """(all pairs, 3) f_r of the reference."""
    picture: FloatArray
    """(pixels, 3) CIELAB of the reference."""
    chroma: FloatArray
    """(pixels, 1) weight of a* and b*."""
    highlight_weight: float

    @classmethod
    def of(cls, reference: Evaluable, size: int, highlight_weight: float) -> Views:
        """Return the views of a reference in R, G, B on a sphere of `size` pixels."""
        sphere, lights = Sphere(size), studio()
        scale = exposure_scale(sphere.shade(reference, lights), sphere.mask)
        queries = sphere.directions(lights)
        near_wi, near_wo = _highlight()
        wi, wo = np.vstack([queries.wi, near_wi]), np.vstack([queries.wo, near_wo])
        value = reference.evaluate(wi, wo)
        light = scale * lights.irradiance[queries.light] * queries.cosine[:, None]
        pixels = len(sphere.normal)
        picture = _lab(_gathered(value[: len(light)] * light, queries.pixel, pixels))
        chroma = 1.0 / (1.0 + 0.045 * np.hypot(picture[:, 1], picture[:, 2]))
        return cls(
            PairAngles.of(wi, wo), queries.pixel, light, value, picture, chroma[:, None],
            highlight_weight,
        )  # fmt: skip

    def residuals(self, material: AnalyticMaterial) -> FloatArray:
        """Return the residuals (m,), in units of CIELAB, scaled so that means are compared."""
        value = material.at(self.angles)
        n = len(self.light)
        shown = _lab(_gathered(value[:n] * self.light, self.pixel, len(self.picture)))
        off = (shown - self.picture) * np.hstack([np.ones_like(self.chroma), *[self.chroma] * 2])
        ratio = np.log((value[n:] + _BLACK) / (np.maximum(self.value[n:], 0.0) + _BLACK))
        share = self.highlight_weight * np.sqrt(off.size / ratio.size)
        return np.concatenate([off.ravel(), share * _LAB_OF_LN * ratio.ravel()])

    def first_guess(self) -> Ggx:
        """Return the GGX lobe over a diffuse base that comes closest, of a few widths.

        For a given width both are linear in the values: least squares of relative errors.
        """
        from brdfit.export.ggx_material import GgxMaterial

        found = []
        for alpha in _ALPHAS:
            diffuse, f0 = self._linear(alpha)
            material = GgxMaterial(tuple(diffuse), tuple(f0), alpha**0.5)
            found.append((float(np.mean(np.abs(self.residuals(material)))), material.model))
        return min(found, key=lambda pair: pair[0])[1]

    def _linear(self, alpha: float) -> tuple[FloatArray, FloatArray]:
        from scipy.optimize import lsq_linear

        # lobe F = f0 (lobe - grazing) + grazing
        lobe = Ggx(diffuse=0.0, f0=[0.0, 1.0], alpha=alpha).at(self.angles)
        grazing = lobe[:, 0]
        solutions = []
        for value in self.value.T:
            weight = 1.0 / (np.maximum(value, 0.0) + 10.0 * _BLACK)
            columns = np.stack([np.full_like(value, 1.0 / np.pi), lobe[:, 1] - grazing], axis=1)
            fit = lsq_linear(columns * weight[:, None], (value - grazing) * weight, (0.0, 1.0))
            solutions.append(fit.x)
        diffuse, f0 = np.array(solutions).T
        return diffuse, f0


def _highlight() -> tuple[FloatArray, FloatArray]:
    u = (np.arange(_HIGHLIGHT_ANGLES) + 0.5) / _HIGHLIGHT_ANGLES
    theta_h = u * u * np.deg2rad(75.0)
    grid = np.meshgrid(theta_h, np.deg2rad(_THETA_D), (0.0, np.pi / 2), indexing="ij")
    wi, wo = directions_from_half_diff(*(axis.ravel() for axis in grid))
    above = (wi[:, 2] > _HORIZON) & (wo[:, 2] > _HORIZON)
    return wi[above], wo[above]


def _gathered(value: FloatArray, pixel: IntArray, pixels: int) -> FloatArray:
    columns = [np.bincount(pixel, weights=column, minlength=pixels) for column in value.T]
    return np.stack(columns, axis=1)


def _lab(linear: FloatArray) -> FloatArray:
    """CIELAB under D65 of exposed linear sRGB; above white the logarithm takes over."""
    bright = np.where(linear > 1.0, 1.0 + np.log(np.maximum(linear, 1.0)), linear)
    colour = colour_library()
    space = colour.RGB_COLOURSPACES["sRGB"]
    xyz = bright @ np.asarray(space.matrix_RGB_to_XYZ).T
    return np.asarray(colour.XYZ_to_Lab(xyz, illuminant=space.whitepoint))
