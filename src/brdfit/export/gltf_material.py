"""The metallic-roughness material of glTF 2.0 with its ratified extensions.

    dielectric = diffuse (1 - max F) + lobe F      F = f0 + (f90 - f0) (1 - wi . wh)^5
                 f0 = specular reflectance, f90 = specular      (KHR_materials_specular, _ior)
    metal      = lobe (base_color + (1 - base_color) (1 - wi . wh)^5)
    base       = (1 - metallic) dielectric + metallic metal
    coated     = (1 - c) base + c lobe_coat,  c = clearcoat (0.04 + 0.96 (1 - cos_o)^5)

lobe = D G2 / (4 cos_i cos_o) is GGX of alpha = roughness^2; diffuse = base_color / pi. The coat
makes it reciprocal only approximately: it knows the detector's side alone.

References: Khronos Group, glTF 2.0 Specification, Appendix B; the extensions
KHR_materials_specular, KHR_materials_ior and KHR_materials_clearcoat.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.export.form import Form, Parameter, Values, colour
from brdfit.export.ggx_material import ROUGHNESS
from brdfit.export.interface import ggx_lobe, ior_of_f0, schlick
from brdfit.models import Ggx, PairAngles

__all__ = ["FORMS", "GltfMaterial"]

_COAT_F0 = 0.04
# (n - 1)^2 / (n + 1)^2 of an index of 5: what is beyond is a metal.
_MOST_F0 = 0.44


@dataclass(frozen=True)
class GltfMaterial:
    """Parameters in linear sRGB; `reflectance` stands for index of refraction and tint."""

    base_color: tuple[float, float, float]
    roughness: float
    metallic: float = 0.0
    specular: float = 1.0
    """Weight of the dielectric's lobe, and its reflectance at grazing."""
    reflectance: tuple[float, float, float] = (_COAT_F0, _COAT_F0, _COAT_F0)
    """Of the dielectric at normal incidence, before `specular`."""
    clearcoat: float = 0.0
    clearcoat_roughness: float = 0.0

    @property
    def ior(self) -> float:
        """Index of refraction that reflects the largest of `reflectance`."""
        return ior_of_f0(max(self.reflectance))

    @property
    def specular_color(self) -> tuple[float, float, float]:
        """`reflectance` over its largest channel."""
        most = max(self.reflectance)
        return colour(np.asarray(self.reflectance) / most) if most > 0.0 else (1.0, 1.0, 1.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, 3), 1/sr, as if every direction were above the horizon."""
        base_color = np.asarray(self.base_color)
        lobe = ggx_lobe(angles, self.roughness**2)
        f0 = self.specular * np.asarray(self.reflectance)
        fresnel = schlick(angles.cos_d, f0, self.specular)
        dielectric = base_color / np.pi * (1.0 - fresnel.max(axis=1, keepdims=True))
        dielectric = dielectric + lobe * fresnel
        metal = lobe * schlick(angles.cos_d, base_color)
        value = (1.0 - self.metallic) * dielectric + self.metallic * metal
        if self.clearcoat > 0.0:
            coat = ggx_lobe(angles, self.clearcoat_roughness**2)
            share = self.clearcoat * schlick(angles.cos_o, _COAT_F0)
            value = (1.0 - share) * value + share * coat
        return np.asarray(value)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, 3) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters by glTF's names, without those that do nothing."""
        found: dict[str, Any] = {
            "baseColorFactor": list(self.base_color),
            "metallicFactor": self.metallic,
            "roughnessFactor": self.roughness,
        }
        if self.metallic < 1.0:
            found["ior"] = self.ior
            found["specularFactor"] = self.specular
            found["specularColorFactor"] = list(self.specular_color)
        if self.clearcoat > 0.0:
            found["clearcoatFactor"] = self.clearcoat
            found["clearcoatRoughnessFactor"] = self.clearcoat_roughness
        return found


def _make(values: Values) -> GltfMaterial:
    scalars = {
        name: float(value[0])
        for name, value in values.items()
        if name not in ("base_color", "reflectance")
    }
    colours = {
        name: colour(values[name]) for name in ("base_color", "reflectance") if name in values
    }
    return GltfMaterial(**colours, **scalars)  # type: ignore[arg-type]


def _make_metal(values: Values) -> GltfMaterial:
    return _make({**values, "metallic": np.ones(1)})


def _dielectrics(guess: Ggx) -> Sequence[Values]:
    f0 = np.clip(np.asarray(guess.f0), 1e-3, _MOST_F0)
    base = np.asarray(guess.diffuse)
    roughness = np.sqrt(np.asarray(guess.alpha)[:1])
    start = {
        "base_color": base,
        "roughness": roughness,
        "specular": np.full(1, 0.9),
        "reflectance": np.full(1, f0.mean()),
        "clearcoat": np.full(1, 0.5),
        "clearcoat_roughness": 0.6 * roughness,
    }
    # the highlight may be the base's, or the coat's over a wider lobe
    wider = {"roughness": np.minimum(1.0, 2.5 * roughness), "clearcoat_roughness": roughness}
    return [start, start | wider, start | wider | {"specular": np.full(1, 0.4)}]


def _plain(guess: Ggx) -> Sequence[Values]:
    start = _dielectrics(guess)[0]
    return [start, {**start, "specular": np.full(1, 0.4)}]


def _tinted(guess: Ggx) -> Sequence[Values]:
    f0 = np.clip(np.asarray(guess.f0), 1e-3, _MOST_F0)
    return [{**start, "reflectance": f0} for start in _plain(guess)[:1]]


def _coated_tinted(guess: Ggx) -> Sequence[Values]:
    f0 = np.clip(np.asarray(guess.f0), 1e-3, _MOST_F0)
    return [{**start, "reflectance": f0} for start in _dielectrics(guess)]


def _metals(guess: Ggx) -> Sequence[Values]:
    base = np.clip(np.asarray(guess.f0) + np.asarray(guess.diffuse), 0.0, 1.0)
    return [{**start, "base_color": base} for start in _dielectrics(guess)[:2]]


_BASE = Parameter("base_color", 3, root=True)
_SPECULAR = Parameter("specular")
_GREY = Parameter("reflectance", 1, high=_MOST_F0, root=True)
_TINT = Parameter("reflectance", 3, high=_MOST_F0, root=True)
_COAT = (Parameter("clearcoat"), Parameter("clearcoat_roughness", low=0.03))

FORMS = (
    Form("dielectric", (_BASE, ROUGHNESS, _SPECULAR, _GREY), _make, _plain),
    Form("metal", (_BASE, ROUGHNESS), _make_metal, _metals),
    Form("tinted dielectric", (_BASE, ROUGHNESS, _SPECULAR, _TINT), _make, _tinted),
    Form("coated dielectric", (_BASE, ROUGHNESS, _SPECULAR, _GREY, *_COAT), _make, _dielectrics),
    Form("coated metal", (_BASE, ROUGHNESS, *_COAT), _make_metal, _metals),
    Form("coated tinted", (_BASE, ROUGHNESS, _SPECULAR, _TINT, *_COAT), _make, _coated_tinted),
)
"""From the plainer to the richer."""
