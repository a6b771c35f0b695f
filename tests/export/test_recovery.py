"""A material of a model's own making gives its parameters back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.albedo import Evaluable
from brdfit.errors import UsageError
from brdfit.export import AnalyticSettings, GltfMaterial, OpenPbrMaterial, fit_analytic
from brdfit.models import Ggx
from brdfit.table import Table

Tabulate = Callable[[Evaluable], Table]

TWO_PERCENT = 0.02

DIELECTRICS = {
    "glossy": Ggx(diffuse=[0.1, 0.3, 0.5], f0=0.06, alpha=0.02),
    "satin": Ggx(diffuse=[0.3, 0.2, 0.1], f0=0.04, alpha=0.2),
    "matte": Ggx(diffuse=[0.4, 0.4, 0.3], f0=0.04, alpha=0.5),
}
METALS = {
    "polished": Ggx(diffuse=0.0, f0=[0.9, 0.6, 0.3], alpha=0.03),
    "brushed": Ggx(diffuse=0.0, f0=[0.55, 0.55, 0.6], alpha=0.15),
    "blasted": Ggx(diffuse=0.0, f0=[0.9, 0.9, 0.8], alpha=0.45),
}


def close(found: object, expected: object) -> None:
    np.testing.assert_allclose(
        np.asarray(found), np.asarray(expected), rtol=TWO_PERCENT, atol=0.0005
    )


@pytest.mark.parametrize("name", [*DIELECTRICS, *METALS])
def test_a_ggx_material_gives_its_own_parameters_back(name: str, tabulate: Tabulate) -> None:
    model = {**DIELECTRICS, **METALS}[name]
    found = fit_analytic(tabulate(model), "ggx").material.parameters()
    for parameter in ("diffuse", "f0"):
        close(found[parameter], np.broadcast_to(getattr(model, parameter), 3))
    close(found["alpha"], np.asarray(model.alpha)[0])


@pytest.mark.parametrize("name", METALS)
def test_a_ggx_metal_is_a_metal_of_gltf(name: str, tabulate: Tabulate) -> None:
    settings = AnalyticSettings(forms=("dielectric", "metal"))
    fit = fit_analytic(tabulate(METALS[name]), "gltf", settings)
    found = fit.material.parameters()
    assert fit.form == "metal"
    assert found["metallicFactor"] == 1.0
    close(found["baseColorFactor"], METALS[name].f0)
    close(found["roughnessFactor"], np.sqrt(METALS[name].alpha)[0])
    assert fit.perceptual_error < 0.1


def test_a_ggx_dielectric_is_a_dielectric_of_gltf(tabulate: Tabulate) -> None:
    """The same lobe; the base is as much brighter as glTF's lobe takes light away from it."""
    model = DIELECTRICS["satin"]
    fit = fit_analytic(tabulate(model), "gltf", AnalyticSettings(forms=("dielectric",)))
    found = fit.material.parameters()
    assert fit.form == "dielectric"
    close(found["roughnessFactor"], np.sqrt(model.alpha)[0])
    close(found["ior"], 1.5)
    close(np.array(found["baseColorFactor"]) * (1.0 - 0.04), model.diffuse)
    assert fit.perceptual_error < 0.2


@pytest.mark.parametrize(
    ("form", "material"),
    [
        ("dielectric", GltfMaterial((0.5, 0.3, 0.1), 0.35, specular=0.7)),
        (
            "coated dielectric",
            GltfMaterial((0.2, 0.4, 0.6), 0.6, clearcoat=0.8, clearcoat_roughness=0.2),
        ),
        ("dielectric", OpenPbrMaterial((0.5, 0.3, 0.1), 0.35, specular_ior=1.6)),
        ("metal", OpenPbrMaterial((0.9, 0.6, 0.4), 0.3, 1.0, specular_color=(0.9, 0.8, 0.7))),
    ],
)
def test_a_material_of_a_target_gives_its_own_parameters_back(
    form: str, material: GltfMaterial | OpenPbrMaterial
) -> None:
    model = "gltf" if isinstance(material, GltfMaterial) else "openpbr"
    fit = fit_analytic(material, model, AnalyticSettings(forms=(form,)))
    assert fit.perceptual_error < 0.1
    found, expected = fit.material.parameters(), material.parameters()
    assert set(found) == set(expected)
    for name, value in expected.items():
        close(found[name], value)


def test_the_plainest_form_is_taken_that_no_richer_one_beats(tabulate: Tabulate) -> None:
    fit = fit_analytic(tabulate(DIELECTRICS["satin"]), "gltf")
    assert fit.tried[fit.form] == fit.perceptual_error
    assert min(fit.tried.values()) >= fit.perceptual_error - fit.settings.worth
    assert list(fit.tried).index(fit.form) == 0


def test_a_reference_of_one_channel_is_refused() -> None:
    with pytest.raises(UsageError, match="R, G, B"):
        fit_analytic(Ggx(diffuse=0.3), "gltf")


def test_an_unknown_form_is_refused_with_those_there_are() -> None:
    with pytest.raises(UsageError, match="coated metal"):
        fit_analytic(DIELECTRICS["satin"], "gltf", AnalyticSettings(forms=("velvet",)))


def test_an_unknown_model_is_refused_with_those_there_are() -> None:
    with pytest.raises(UsageError, match="openpbr"):
        fit_analytic(DIELECTRICS["satin"], "phong")
