"""The OpenPBR surface as the shaders of MaterialX evaluate it: base, specular, coat.

    dielectric = tint F lobe c + (1 - E) base_color / pi       F unpolarised, of specular_ior
    metal      = F82 lobe c                                    F82 of base_color, specular_color
    base       = (1 - metalness) dielectric + metalness metal
    coated     = w F_coat lobe_coat c_coat + (1 - w E_coat) base,  w = coat_weight

lobe is GGX of alpha = roughness^2; c = 1 + F (1 - Ess) / Ess makes up for light that bounces
more than once, Ess being the albedo of the lobe without Fresnel; E = (f0 A + B) c is what the
upper lobe takes from the layer below. A coat widens the lobe below it and lowers its ratio of
indices. coat_darkening is 0: what the base looks like under the coat is its base_color.

References: Academy Software Foundation, OpenPBR Surface specification 1.1; E. Turquin,
"Practical multiple scattering compensation for microfacet models", 2019 (c); N. Hoffman,
"Generalization of Adobe's Fresnel Model", 2023 (F82).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.export.albedo_split import albedo_split
from brdfit.export.form import Form, Parameter, Values, colour
from brdfit.export.ggx_material import ROUGHNESS
from brdfit.export.interface import dielectric_fresnel, f0_of_ior, ggx_lobe, ior_of_f0, schlick
from brdfit.models import Ggx, PairAngles

__all__ = ["COAT_IOR", "FORMS", "OpenPbrMaterial"]

COAT_IOR = 1.5
_WHITE = (1.0, 1.0, 1.0)
_MOST_F0 = 0.44
# Where F82 has its name from: about 82 degrees.
_COS_82 = 1.0 / 7.0


@dataclass(frozen=True)
class OpenPbrMaterial:
    """Parameters by OpenPBR's names, linear sRGB; what is not named has its default."""

    base_color: tuple[float, float, float]
    specular_roughness: float
    base_metalness: float = 0.0
    specular_color: tuple[float, float, float] = _WHITE
    """Tint of a dielectric's lobe; of a metal its reflectance near grazing."""
    specular_ior: float = 1.5
    coat_weight: float = 0.0
    coat_roughness: float = 0.0

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, 3), 1/sr, as if every direction were above the horizon."""
        w = self.coat_weight
        alpha, ior = self._under_the_coat()
        lobe = ggx_lobe(angles, alpha)
        value = np.zeros(1)
        if self.base_metalness < 1.0:
            top, kept = _dielectric(angles, lobe, alpha, ior)
            tinted = top * np.asarray(self.specular_color)
            dielectric = tinted + kept * (np.asarray(self.base_color) / np.pi)
            value = (1.0 - self.base_metalness) * dielectric
        if self.base_metalness > 0.0:
            fresnel = self._metal_fresnel(angles.cos_d)
            metal = lobe * fresnel * _compensation(angles, alpha, fresnel)
            value = value + self.base_metalness * metal
        if w > 0.0:
            coat_alpha = self.coat_roughness**2
            coat_lobe = ggx_lobe(angles, coat_alpha)
            top, kept = _dielectric(angles, coat_lobe, coat_alpha, COAT_IOR)
            value = w * top + (1.0 - w * (1.0 - kept)) * value
        return value

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, 3) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def parameters(self) -> dict[str, Any]:
        """Return the inputs of `open_pbr_surface`, without those that do nothing."""
        found: dict[str, Any] = {
            "base_color": list(self.base_color),
            "base_metalness": self.base_metalness,
            "specular_roughness": self.specular_roughness,
        }
        if self.specular_color != _WHITE:
            found["specular_color"] = list(self.specular_color)
        if self.base_metalness < 1.0:
            found["specular_ior"] = self.specular_ior
        if self.coat_weight > 0.0:
            found["coat_weight"] = self.coat_weight
            found["coat_roughness"] = self.coat_roughness
            found["coat_ior"] = COAT_IOR
            found["coat_darkening"] = 0.0
        return found

    def _under_the_coat(self) -> tuple[float, float]:
        """Return (alpha, relative index) of the base's lobe as it is seen through the coat."""
        r, w = self.specular_roughness, self.coat_weight
        rougher = min(1.0, 2.0 * self.coat_roughness**4 + r**4) ** 0.25
        roughness = (1.0 - w) * r + w * rougher
        ratio = max(self.specular_ior / COAT_IOR, COAT_IOR / self.specular_ior)
        return roughness**2, (1.0 - w) * self.specular_ior + w * ratio

    def _metal_fresnel(self, cosine: FloatArray) -> FloatArray:
        f0 = np.asarray(self.base_color)
        far = 1.0 - _COS_82
        dip = schlick(np.asarray(_COS_82), f0) * (1.0 - np.asarray(self.specular_color))
        dip = dip / (_COS_82 * far**6)
        value = schlick(cosine, f0) - dip * cosine * (1.0 - cosine) ** 6
        return np.asarray(np.maximum(value, 0.0))


def _dielectric(
    angles: PairAngles, lobe: FloatArray, alpha: float, ior: float
) -> tuple[FloatArray, FloatArray]:
    """Return (reflected f_r, share that the layer below keeps), each (n, 1)."""
    fresnel = dielectric_fresnel(angles.cos_d, ior)
    compensation = _compensation(angles, alpha, fresnel)
    a, b = albedo_split(angles.cos_o, alpha)
    taken = (f0_of_ior(ior) * a + b) * compensation
    return lobe * fresnel * compensation, np.maximum(1.0 - taken, 0.0)


def _compensation(angles: PairAngles, alpha: float, fresnel: FloatArray) -> FloatArray:
    whole = sum(albedo_split(angles.cos_o, alpha))
    return np.asarray(1.0 + fresnel * (1.0 - whole) / whole)


def _make(values: Values) -> OpenPbrMaterial:
    given: dict[str, Any] = {"base_color": colour(values["base_color"])}
    if "specular_color" in values:
        given["specular_color"] = colour(values["specular_color"])
    given["specular_roughness"] = float(values["roughness"][0])
    if "f0" in values:
        given["specular_ior"] = ior_of_f0(float(values["f0"][0]))
    for name in ("base_metalness", "coat_weight", "coat_roughness"):
        if name in values:
            given[name] = float(values[name][0])
    return OpenPbrMaterial(**given)


def _make_metal(values: Values) -> OpenPbrMaterial:
    return _make({**values, "base_metalness": np.ones(1)})


def _dielectrics(guess: Ggx) -> Sequence[Values]:
    f0 = np.asarray(guess.f0)
    roughness = np.sqrt(np.asarray(guess.alpha)[:1])
    start = {
        "base_color": np.asarray(guess.diffuse),
        "roughness": roughness,
        "f0": np.full(1, np.clip(f0.mean(), 1e-3, _MOST_F0)),
        "specular_color": f0 / max(f0.max(), 1e-6),
        "coat_weight": np.full(1, 0.5),
        "coat_roughness": 0.6 * roughness,
    }
    # the highlight may be the base's, or the coat's over a wider lobe
    wider = {"roughness": np.minimum(1.0, 2.5 * roughness), "coat_roughness": roughness}
    return [start, start | wider]


def _plain(guess: Ggx) -> Sequence[Values]:
    return _dielectrics(guess)[:1]


def _metals(guess: Ggx) -> Sequence[Values]:
    base = np.clip(np.asarray(guess.f0) + np.asarray(guess.diffuse), 0.0, 1.0)
    metal = {"base_color": base, "specular_color": np.full(3, 0.95)}
    return [{**start, **metal} for start in _dielectrics(guess)]


_BASE = Parameter("base_color", 3, root=True)
_COLOUR = Parameter("specular_color", 3)
_F0 = Parameter("f0", high=_MOST_F0, root=True)
_COAT = (Parameter("coat_weight"), Parameter("coat_roughness", low=0.03))

FORMS = (
    Form("dielectric", (_BASE, ROUGHNESS, _F0), _make, _plain),
    Form("metal", (_BASE, ROUGHNESS, _COLOUR), _make_metal, _metals),
    Form("tinted dielectric", (_BASE, ROUGHNESS, _F0, _COLOUR), _make, _plain),
    Form("coated dielectric", (_BASE, ROUGHNESS, _F0, *_COAT), _make, _dielectrics),
    Form("coated metal", (_BASE, ROUGHNESS, _COLOUR, *_COAT), _make_metal, _metals),
    Form("coated tinted", (_BASE, ROUGHNESS, _F0, _COLOUR, *_COAT), _make, _dielectrics),
)
"""From the plainer to the richer."""
