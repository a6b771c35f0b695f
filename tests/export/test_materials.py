"""The targets' materials: their formulas for one pair, and the laws that they obey."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.export import GltfMaterial, OpenPbrMaterial
from brdfit.export.albedo_split import albedo_split
from brdfit.geometry import directions_from_half_diff, directions_from_spherical
from brdfit.models import Ggx

Draw = Callable[[int], tuple[FloatArray, FloatArray]]

MATERIALS = {
    "gltf dielectric": GltfMaterial((0.5, 0.3, 0.1), 0.4),
    "gltf metal": GltfMaterial((0.9, 0.6, 0.4), 0.3, metallic=1.0),
    "gltf coated": GltfMaterial((0.5, 0.3, 0.1), 0.6, clearcoat=0.7, clearcoat_roughness=0.2),
    "openpbr dielectric": OpenPbrMaterial((0.5, 0.3, 0.1), 0.4),
    "openpbr metal": OpenPbrMaterial((0.9, 0.6, 0.4), 0.3, 1.0, (0.9, 0.8, 0.7)),
    "openpbr coated": OpenPbrMaterial((0.5, 0.3, 0.1), 0.6, coat_weight=0.7, coat_roughness=0.2),
}


@pytest.mark.parametrize("name", MATERIALS)
def test_values_are_finite_and_not_negative_and_zero_below(
    name: str, random_directions: Draw
) -> None:
    wi, wo = random_directions(400)
    value = MATERIALS[name].evaluate(wi, wo)
    assert np.isfinite(value).all()
    assert (value > 0.0).all()
    assert (MATERIALS[name].evaluate(wi, wo * [1.0, 1.0, -1.0]) == 0.0).all()


@pytest.mark.parametrize("name", ["gltf dielectric", "gltf metal"])
def test_exchanging_light_and_detector_changes_nothing(name: str, random_directions: Draw) -> None:
    wi, wo = random_directions(400)
    material = MATERIALS[name]
    np.testing.assert_allclose(material.evaluate(wi, wo), material.evaluate(wo, wi), rtol=1e-9)


@pytest.mark.parametrize("roughness", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("coat", [0.0, 1.0])
def test_white_of_openpbr_reflects_what_it_receives(roughness: float, coat: float) -> None:
    white = OpenPbrMaterial((1.0,) * 3, roughness, coat_weight=coat, coat_roughness=roughness)
    seen = directional_albedo(_Reversed(white), np.deg2rad([5.0, 30.0, 60.0]))
    np.testing.assert_allclose(seen, 1.0, atol=0.04)


class _Reversed:
    """What a detector sees under an even surround: the sum runs over the light's side."""

    def __init__(self, material: OpenPbrMaterial) -> None:
        self._material = material

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return self._material.evaluate(wo, np.ascontiguousarray(wi))


def test_albedo_split_is_the_integral_between_its_nodes() -> None:
    theta, alpha = np.deg2rad([12.0, 47.0, 71.0]), 0.31
    for f0 in (0.0, 0.04, 0.5, 1.0):
        a, b = albedo_split(np.cos(theta), alpha)
        whole = directional_albedo(Ggx(diffuse=0.0, f0=f0, alpha=alpha), theta)[:, 0]
        np.testing.assert_allclose(f0 * a + b, whole, atol=0.003)


def test_a_dielectric_of_gltf_by_hand() -> None:
    """Mirror pair at 60 degrees: theta_h = 0, theta_d = 60."""
    wi, wo = directions_from_half_diff(*(np.array([x]) for x in (0.0, math.pi / 3, 0.0)))
    material = GltfMaterial((0.5, 0.3, 0.1), 0.5, specular=0.8, reflectance=(0.05, 0.05, 0.02))
    a2, cos = 0.5**4, 0.5
    lobe = (1.0 / (math.pi * a2)) / (4.0 * cos * math.sqrt(a2 + (1.0 - a2) * cos**2))
    fresnel = np.array([0.04, 0.04, 0.016]) + (0.8 - np.array([0.04, 0.04, 0.016])) * 0.5**5
    expected = np.array([0.5, 0.3, 0.1]) / math.pi * (1.0 - fresnel[0]) + lobe * fresnel
    np.testing.assert_allclose(material.evaluate(wi, wo)[0], expected, rtol=1e-6)


def test_the_tint_of_a_metal_of_openpbr_acts_at_82_degrees() -> None:
    theta = math.acos(1.0 / 7.0)
    wi = directions_from_spherical(np.array([theta]), np.zeros(1))
    wo = directions_from_spherical(np.array([theta]), np.full(1, np.pi))
    plain = OpenPbrMaterial((0.7, 0.7, 0.7), 0.3, 1.0)
    tinted = OpenPbrMaterial((0.7, 0.7, 0.7), 0.3, 1.0, specular_color=(1.0, 0.5, 0.25))
    ratio = tinted.evaluate(wi, wo)[0] / plain.evaluate(wi, wo)[0]
    # the light of further bounces takes part with the square of the reflectance
    np.testing.assert_allclose(ratio, [1.0, 0.5, 0.25], rtol=0.08)


def test_index_of_refraction_and_tint_are_the_reflectance() -> None:
    material = GltfMaterial((0.5, 0.3, 0.1), 0.5, reflectance=(0.04, 0.02, 0.01))
    assert material.ior == pytest.approx(1.5)
    assert material.specular_color == pytest.approx((1.0, 0.5, 0.25))
