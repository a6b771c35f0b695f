"""Laws that every analytic model obeys, and each model against its formula for one pair."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_half_diff, directions_from_spherical
from brdfit.models import (
    COS_FLOOR,
    Abc,
    CoatedDiffuse,
    Flakes,
    Ggx,
    Lambert,
    Layered,
    Particulate,
    PearlFlakes,
    Retro,
    RoughDiffuse,
    Sheen,
    ShiftedGamma,
    Student,
    ThinFilm,
)

GAMMA = {
    "rho_d": [0.05, 0.03, 0.02],
    "rho_s": [0.04, 0.66, 0.27],
    "alpha": [0.015, 0.03, 0.05],
    "p": [0.46, 0.45, 0.53],
    "f0": [6.05, 0.24, 0.58],
    "f1": [5.05, 0.18, 0.48],
    "kap": [46.4, 24.6, 14.8],
    "lambda_": [2.6, 3.0, 2.8],
    "c": [1.1e-7, 1.1e-7, 5.3e-8],
    "k": [47.8, 36.3, 31.6],
    "theta0": [0.21, 0.066, -0.066],
}
ABC = {"k_d": [0.025, 0.022, 0.016], "a": [51.7, 37.9, 27.4], "b": 10482.0, "c": 0.82, "ior": 2.24}

MODELS: dict[str, Any] = {
    "shifted_gamma": ShiftedGamma(**GAMMA),
    "abc": Abc(**ABC),
    "ggx": Ggx(diffuse=[0.3, 0.2, 0.1], f0=0.04, alpha=0.15),
    "lambert": Lambert([0.8, 0.5, 0.2]),
    "mirror_like": Ggx(diffuse=0.001, f0=[0.9, 0.7, 0.5], alpha=0.002),
    "thin_film": ThinFilm(0.1, 320.0, [610.0, 545.0, 455.0], ior=1.6, base=1.8, extinction=3.0),
    "coated_diffuse": CoatedDiffuse([0.9, 0.3, 0.01], ior=[1.3, 1.5, 1.8]),
    "flakes": Flakes([0.05, 0.2, 0.6], [0.9, 0.4, 0.02], ior=1.5),
    "pearl_flakes": PearlFlakes(0.2, 0.5, 110.0, [610.0, 545.0, 455.0], extinction=[0.0, 1.0, 6.0]),
    "retro": Retro([0.9, 0.2, 0.05], [0.02, 0.1, 0.6]),
    "particulate": Particulate([0.99, 0.5, 0.05], [-0.5, 0.0, 0.6], [1.0, 0.0, 0.5], 0.05),
    "rough_diffuse": RoughDiffuse([0.9, 0.3, 0.02], [0.0, 0.5, 1.0]),
    "student": Layered(
        (Student([0.9, 0.3, 0.04], [0.004, 0.1, 0.6], [1.2, 3.0, 40.0]), Lambert(0.01))
    ),
    "sheen": Layered((Sheen([0.9, 0.3, 0.1], [0.05, 0.3, 1.0]), Lambert(0.01))),
}
Draw = Callable[[int], tuple[FloatArray, FloatArray]]


@pytest.fixture(params=sorted(MODELS))
def model(request: pytest.FixtureRequest) -> Any:
    return MODELS[request.param]


def test_exchanging_light_and_detector_changes_nothing(model: Any, random_directions: Draw) -> None:
    wi, wo = random_directions(500)
    np.testing.assert_allclose(model.evaluate(wi, wo), model.evaluate(wo, wi), rtol=1e-9)


def test_rotating_the_sample_changes_nothing(model: Any, random_directions: Draw) -> None:
    wi, wo = random_directions(500)
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(
        model.evaluate(wi @ turn.T, wo @ turn.T), model.evaluate(wi, wo), rtol=1e-6
    )


def test_models_are_symmetric_about_a_right_angle_of_phi_d(
    model: Any, rng: np.random.Generator
) -> None:
    theta_h, theta_d = rng.uniform(0.0, 0.7, (2, 300))
    phi_d = rng.uniform(0.0, np.pi, 300)
    here = model.evaluate(*directions_from_half_diff(theta_h, theta_d, phi_d))
    mirrored = model.evaluate(*directions_from_half_diff(theta_h, theta_d, np.pi - phi_d))
    np.testing.assert_allclose(here, mirrored, rtol=1e-9)


def test_values_are_finite_and_above_zero_up_to_the_horizon(
    model: Any, rng: np.random.Generator
) -> None:
    theta = np.pi / 2 - 10.0 ** rng.uniform(-9, 0, (2, 400))
    wi, wo = directions_from_spherical(theta, rng.uniform(-np.pi, np.pi, (2, 400)))
    value = model.evaluate(wi, wo)
    assert np.isfinite(value).all()
    assert (value > 0.0).all()


def test_there_is_nothing_below_the_horizon(model: Any) -> None:
    up, down = np.array([[0.6, 0.0, 0.8]]), np.array([[0.6, 0.0, -0.8]])
    assert not model.evaluate(up, down).any()
    assert not model.evaluate(down, up).any()


def test_many_columns_at_once_equal_each_column_alone(random_directions: Draw) -> None:
    wi, wo = random_directions(50)
    together = MODELS["shifted_gamma"].evaluate(wi, wo)
    for column in range(3):
        alone = ShiftedGamma(**{name: values[column] for name, values in GAMMA.items()})
        np.testing.assert_allclose(alone.evaluate(wi, wo)[:, 0], together[:, column], rtol=1e-12)


PAIR = directions_from_half_diff(0.2, 0.7, 1.1)


def _angles() -> tuple[float, float, float, float]:
    wi, wo = PAIR
    return float(wi[2]), float(wo[2]), math.cos(0.2), math.cos(0.7)


def test_shifted_gamma_is_its_formula() -> None:
    cos_i, cos_o, cos_h, c = _angles()
    for channel in range(3):
        q = {name: values[channel] for name, values in GAMMA.items()}
        x = q["alpha"] + (1 / cos_h**2 - 1) / q["alpha"]
        d = q["kap"] * math.exp(-x) / (math.pi * x ** q["p"] * cos_h**4)
        f = q["f0"] - c * q["f1"] + (1 - c) ** 5 * (1 - q["f0"])
        g = 1.0
        for cosine in (cos_i, cos_o):
            u = max(0.0, math.acos(cosine) - q["theta0"])
            g *= min(1.0, max(0.0, 1 + q["lambda_"] * (1 - math.exp(q["c"] * u ** q["k"]))))
        expected = (q["rho_d"] + q["rho_s"] * f * d * g / (cos_i * cos_o)) / math.pi
        found = MODELS["shifted_gamma"].evaluate(PAIR[0], PAIR[1])[0, channel]
        assert found == pytest.approx(expected, rel=1e-9)


def test_shifted_gamma_masks_where_its_formula_would_overflow() -> None:
    model = ShiftedGamma(**{**GAMMA, "c": 1e38, "k": 856.0, "theta0": -0.5})
    wi, wo = directions_from_spherical(np.array([[1.4], [1.4]]), np.array([[0.0], [np.pi]]))
    np.testing.assert_allclose(model.evaluate(wi, wo)[0], np.array(GAMMA["rho_d"]) / np.pi)


def test_a_negative_fresnel_term_is_held_at_zero() -> None:
    model = ShiftedGamma(**{**GAMMA, "f0": 0.1, "f1": 0.5})
    up = np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(model.evaluate(up, up)[0], np.array(GAMMA["rho_d"]) / np.pi)


def test_abc_is_its_formula() -> None:
    cos_i, cos_o, cos_h, c = _angles()
    n, b, power = 2.24, 10482.0, 0.82
    cos_t = math.sqrt(1 - (1 - c * c) / n**2)
    perpendicular = ((c - n * cos_t) / (c + n * cos_t)) ** 2
    parallel = ((cos_t - n * c) / (cos_t + n * c)) ** 2
    fresnel = (perpendicular + parallel) / 2
    groove = min(1.0, 2 * cos_h * cos_o / c, 2 * cos_h * cos_i / c)
    for channel in range(3):
        d = ABC["a"][channel] / (1 + b * (1 - cos_h)) ** power  # type: ignore[index]
        expected = ABC["k_d"][channel] / math.pi + fresnel * d * groove / (  # type: ignore[index]
            math.pi * cos_i * cos_o
        )
        found = MODELS["abc"].evaluate(PAIR[0], PAIR[1])[0, channel]
        assert found == pytest.approx(expected, rel=1e-9)


def test_denominators_stop_shrinking_at_half_a_degree() -> None:
    theta = np.pi / 2 - np.array([1e-3, 1e-6])
    wi, wo = directions_from_spherical(theta, np.zeros(2)), np.tile([0.0, 0.0, 1.0], (2, 1))
    near, nearer = MODELS["abc"].evaluate(wi, wo)
    np.testing.assert_allclose(near, nearer, rtol=0.01)
    assert pytest.approx(math.cos(math.radians(89.5))) == COS_FLOOR


@pytest.mark.parametrize("alpha", [0.1, 0.5, 1.0])
def test_ggx_reflects_no_more_than_it_receives(alpha: float) -> None:
    u, v = (np.arange(300) + 0.5) / 300, (np.arange(200) + 0.5) / 200
    # half vectors drawn as the distribution has them: weight f cos / (D cos_h / (4 wo.wh))
    tan2 = alpha**2 * u / (1 - u)
    cos_h = 1 / np.sqrt(1 + tan2)
    cos_h, phi = (grid.ravel() for grid in np.meshgrid(cos_h, 2 * np.pi * v))
    wh = directions_from_spherical(np.arccos(cos_h), phi)
    wi = np.array([[math.sin(0.8), 0.0, math.cos(0.8)]])
    along = (wh @ wi[0])[:, None]
    wo = 2 * along * wh - wi
    pdf = alpha**2 / (np.pi * (cos_h**2 * (alpha**2 - 1) + 1) ** 2) * cos_h / (4 * along[:, 0])
    seen = (along[:, 0] > 0) & (wo[:, 2] > 0)
    mirror = Ggx(diffuse=0.0, f0=1.0, alpha=alpha).evaluate(np.broadcast_to(wi, wo.shape), wo)
    albedo = np.sum((mirror[:, 0] * wo[:, 2] / pdf)[seen]) / len(wo)
    # loses by single scattering what Heitz 2014 says, and gains nothing
    assert 0.3 < albedo < 1.0


def test_ggx_at_its_roughest_has_an_albedo_in_closed_form() -> None:
    # alpha = 1, normal incidence: f = 1 / (2 pi (1 + cos_o)), albedo 1 - ln 2
    cos_o = (np.arange(2000) + 0.5) / 2000
    wo = directions_from_spherical(np.arccos(cos_o), np.zeros(2000))
    up = np.broadcast_to([0.0, 0.0, 1.0], wo.shape)
    value = Ggx(diffuse=0.0, f0=1.0, alpha=1.0).evaluate(up, wo)[:, 0]
    assert 2 * np.pi * np.mean(value * cos_o) == pytest.approx(1 - math.log(2), rel=1e-4)


def test_lambert_reflects_its_albedo() -> None:
    cos_o = (np.arange(1000) + 0.5) / 1000
    wo = directions_from_spherical(np.arccos(cos_o), np.zeros(1000))
    value = Lambert([0.8, 0.2]).evaluate(np.broadcast_to([0.0, 0.0, 1.0], wo.shape), wo)
    albedo = 2 * np.pi * np.mean(value * cos_o[:, None], axis=0)
    np.testing.assert_allclose(albedo, [0.8, 0.2], rtol=1e-6)


def test_parameters_of_different_lengths_are_named() -> None:
    with pytest.raises(UsageError, match=r"Ggx: f0 has shape \(2,\).*3 columns"):
        Ggx(diffuse=[0.1, 0.2, 0.3], f0=[0.1, 0.2])


def test_a_parameter_that_is_not_finite_is_named() -> None:
    with pytest.raises(UsageError, match="Lambert: albedo"):
        Lambert([0.5, np.nan])


def test_a_mirror_has_no_value() -> None:
    with pytest.raises(UsageError, match="alpha is 0"):
        Ggx(alpha=0.0)


def test_parameters_cannot_be_written_to() -> None:
    with pytest.raises(ValueError, match="read-only"):
        MODELS["lambert"].albedo[0] = 1.0
