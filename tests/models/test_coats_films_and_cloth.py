"""Models of what the measured databases lack: energy, limits, and where each is bright."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical
from brdfit.models import (
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
    Student,
    ThinFilm,
)
from brdfit.models.fresnel import dielectric, film

ANGLES = np.radians([0.0, 20.0, 45.0, 70.0, 85.0])
Draw = Callable[[int], tuple[FloatArray, FloatArray]]


@pytest.mark.parametrize("roughness", [0.0, 0.3, 1.0])
def test_a_white_rough_diffuse_surface_loses_nothing(roughness: float) -> None:
    albedo = directional_albedo(RoughDiffuse(1.0, roughness), ANGLES)
    np.testing.assert_allclose(albedo, 1.0, atol=2e-4)


def test_a_rough_diffuse_surface_without_roughness_is_lambertian(random_directions: Draw) -> None:
    wi, wo = random_directions(100)
    np.testing.assert_allclose(
        RoughDiffuse([0.8, 0.1], 0.0).evaluate(wi, wo), Lambert([0.8, 0.1]).evaluate(wi, wo)
    )


def test_a_white_base_under_a_coat_returns_all_that_enters() -> None:
    albedo = directional_albedo(CoatedDiffuse(1.0, [1.2, 1.5, 2.0]), ANGLES)
    entering = 1.0 - dielectric(np.cos(ANGLES)[:, None], np.array([1.2, 1.5, 2.0]))
    np.testing.assert_allclose(albedo, entering, rtol=1e-4)


def test_a_coat_of_air_is_no_coat(random_directions: Draw) -> None:
    wi, wo = random_directions(100)
    np.testing.assert_allclose(
        CoatedDiffuse(0.3, 1.0).evaluate(wi, wo), Lambert(0.3).evaluate(wi, wo), rtol=1e-9
    )
    bare = Ggx(diffuse=0.0, f0=0.7, alpha=0.3).evaluate(wi, wo)
    np.testing.assert_allclose(Flakes(0.3, 0.7, 1.0).evaluate(wi, wo), bare, rtol=1e-6)


@pytest.mark.parametrize(
    "model",
    [
        Flakes([0.05, 0.3, 1.0], 1.0, 1.5),
        PearlFlakes([0.05, 0.3, 1.0], 1.0, 150.0, 545.0, extinction=6.0),
        ThinFilm([0.05, 0.3, 1.0], 300.0, 545.0, 1.8, 1.0, 5.0),
        Retro(1.0, [0.15, 0.3, 1.0]),
        Sheen(0.8, [0.1, 0.3, 1.0]),
        Particulate([0.3, 0.9, 0.99], [0.0, -0.3, 0.4]),
        Student(1.0, [0.05, 0.2, 0.3], [2.0, 3.0, 50.0]),
    ],
    ids=lambda model: type(model).__name__,
)
def test_nothing_reflects_more_than_it_receives(model: Any) -> None:
    assert (directional_albedo(model, ANGLES) < 1.0).all()


def test_a_retro_reflector_is_a_mirror_of_the_mirrored_direction(random_directions: Draw) -> None:
    wi, wo = random_directions(200)
    turned = wo * [-1.0, -1.0, 1.0]
    forward = Ggx(diffuse=0.0, f0=0.4, alpha=0.3).evaluate(wi, turned)
    np.testing.assert_allclose(Retro(0.4, 0.3).evaluate(wi, wo), forward, rtol=1e-5)


def test_a_retro_reflector_is_brightest_toward_the_light() -> None:
    theta_o = np.radians(np.linspace(-80.0, 80.0, 33))
    wo = directions_from_spherical(theta_o, np.zeros(33))
    wi = np.broadcast_to(directions_from_spherical(np.radians(40.0), 0.0), wo.shape)
    value = Retro(0.5, 0.05).evaluate(wi, wo)[:, 0]
    assert np.degrees(theta_o[np.argmax(value)]) == pytest.approx(40.0)


def test_flakes_are_brightest_in_the_mirror_direction_and_wider_outside_than_inside() -> None:
    theta_o = np.radians(np.arange(-85.0, 86.0))
    wo = directions_from_spherical(theta_o, np.zeros(theta_o.size))
    wi = np.broadcast_to(directions_from_spherical(np.radians(30.0), np.pi), wo.shape)
    coated = Flakes(0.1, 0.8, 1.5).evaluate(wi, wo)[:, 0]
    bare = Ggx(diffuse=0.0, f0=0.8, alpha=0.1).evaluate(wi, wo)[:, 0]
    assert np.degrees(theta_o[np.argmax(coated)]) == pytest.approx(30.0, abs=1.0)
    assert (coated > coated.max() / 2).sum() > 1.3 * (bare > bare.max() / 2).sum()


def test_sheen_is_bright_at_grazing_angles_only() -> None:
    albedo = directional_albedo(Sheen(1.0, 0.2), np.radians([0.0, 80.0]))[:, 0]
    assert albedo[1] > 5.0 * albedo[0]


def test_a_film_of_no_thickness_is_the_base() -> None:
    cosine = np.cos(ANGLES)[:, None]
    none = film(cosine, *(np.array([figure]) for figure in (0.0, 1.4, 1.6, 0.0, 550.0)))
    np.testing.assert_allclose(none, dielectric(cosine, np.array([1.6])), rtol=1e-9)


def test_a_film_of_the_base_is_the_base_whatever_its_thickness() -> None:
    cosine = np.cos(ANGLES)[:, None]
    same = film(cosine, *(np.array([figure]) for figure in (300.0, 1.6, 1.6, 0.0, 550.0)))
    np.testing.assert_allclose(same, dielectric(cosine, np.array([1.6])), rtol=1e-9)


def test_a_metal_without_film_is_its_fresnel_reflectance() -> None:
    # normal incidence: ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)
    found = film(np.ones((1, 1)), *(np.array([x]) for x in (0.0, 1.3, 0.9, 6.0, 550.0)))
    assert found[0, 0] == pytest.approx((0.1**2 + 36.0) / (1.9**2 + 36.0))


def test_a_quarter_wave_film_with_the_mean_index_reflects_nothing_at_its_wavelength() -> None:
    # r1 = r2 and half a wave between: n = sqrt(n_base). The band keeps it from being exact.
    ior, base, wavelength = math.sqrt(1.5), 1.5, 550.0
    cosine, quarter = np.ones((1, 1)), wavelength / (4.0 * ior)
    figures = (quarter, ior, base, 0.0, wavelength)
    found = film(cosine, *(np.array([figure]) for figure in figures))[0, 0]
    assert found < 0.02 * dielectric(cosine, np.array([base]))[0, 0]


def test_the_reflectance_of_a_film_is_a_share(rng: np.random.Generator) -> None:
    cosine = rng.uniform(0.0, 1.0, (200, 1))
    ranges = ((0.0, 2000.0), (1.1, 2.6), (0.1, 3.0), (0.0, 8.0), (430.0, 650.0))
    found = film(cosine, *(rng.uniform(*ends, 50) for ends in ranges))
    assert (found >= 0.0).all()
    assert (found <= 1.0).all()


def test_the_average_over_a_band_is_an_integral() -> None:
    # many narrow bands inside one wide one
    cosine = np.cos(ANGLES)[:, None]
    figures = [np.array([figure]) for figure in (900.0, 2.0, 1.5, 0.0)]
    wide = film(cosine, *figures, np.array([500.0]))
    exact = _over_band(cosine, 500.0)
    np.testing.assert_allclose(wide[:, 0], exact, atol=2e-3)


def _over_band(cosine: FloatArray, middle: float) -> FloatArray:
    """The same film by its characteristic matrix, s and p, 400 wavelengths of the band."""
    thickness, n1, n2 = 900.0, 2.0, 1.5
    wavelengths = middle + 80.0 * ((np.arange(400) + 0.5) / 400 - 0.5)
    cos0 = cosine[:, 0][:, None]
    cos1, cos2 = (np.sqrt(1.0 - (1.0 - cos0**2) / n**2) for n in (n1, n2))
    phase = 2.0 * np.pi * n1 * thickness * cos1 / wavelengths
    total = 0.0
    for p in (False, True):
        y0, y1, y2 = (n / c if p else n * c for n, c in ((1.0, cos0), (n1, cos1), (n2, cos2)))
        b = np.cos(phase) + 1j * np.sin(phase) * y2 / y1
        c = 1j * y1 * np.sin(phase) + y2 * np.cos(phase)
        total = total + 0.5 * np.abs((y0 * b - c) / (y0 * b + c)) ** 2
    return np.asarray(np.mean(total, axis=1))


def test_the_colour_of_a_film_turns_with_the_angle() -> None:
    cosine = np.cos(np.radians([0.0, 60.0]))[:, None]
    bands = np.array([610.0, 545.0, 455.0])
    facing, tilted = film(cosine, *(np.full(3, x) for x in (350.0, 1.5, 1.0, 5.0)), bands)
    assert np.argmin(facing) != np.argmin(tilted)


def test_layers_add_up(random_directions: Draw) -> None:
    wi, wo = random_directions(50)
    parts = (Lambert([0.2, 0.1]), Ggx(0.0, 0.04, 0.1))
    expected = parts[0].evaluate(wi, wo) + parts[1].evaluate(wi, wo)
    np.testing.assert_allclose(Layered(parts).evaluate(wi, wo), expected)


def test_a_material_without_parts_is_refused() -> None:
    with pytest.raises(UsageError, match="no parts"):
        Layered(())


def test_sheen_without_roughness_is_refused() -> None:
    with pytest.raises(UsageError, match="alpha is 0"):
        Sheen(0.5, 0.0)


def test_a_lobe_with_a_tail_of_two_is_ggx(random_directions: Draw) -> None:
    wi, wo = random_directions(200)
    ggx = Ggx(0.0, [0.04, 0.9], [0.01, 0.3]).evaluate(wi, wo)
    np.testing.assert_allclose(Student([0.04, 0.9], [0.01, 0.3]).evaluate(wi, wo), ggx, rtol=1e-9)


def test_a_lobe_without_tail_is_beckmann_in_the_half_angle() -> None:
    theta = np.radians([0.0, 2.0, 5.0, 10.0])
    # wi = wo = wh: every factor but D cos^4 is that of GGX
    w = directions_from_spherical(theta, np.zeros(4))
    ggx = Ggx(0.0, 0.5, 0.1).evaluate(w, w)[:, 0] * (1.0 + np.tan(theta) ** 2 / 0.01) ** 2
    found = Student(0.5, 0.1, 1e7).evaluate(w, w)[:, 0]
    np.testing.assert_allclose(found, ggx * np.exp(-(np.tan(theta) ** 2) / 0.01), rtol=1e-5)


def test_a_tail_that_holds_too_much_light_is_refused() -> None:
    with pytest.raises(UsageError, match="tail is 1 but"):
        Student(0.5, 0.1, 1.0)


def test_particles_shine_back_or_forth_as_their_asymmetry_says() -> None:
    wi, back, forth = directions_from_spherical(np.radians([60.0, 60.0, 60.0]), [0.0, 0.0, np.pi])
    wi, wo = np.stack([wi, wi]), np.stack([back, forth])
    for asymmetry, brighter in ((-0.4, 0), (0.4, 1)):
        assert np.argmax(Particulate(0.5, asymmetry).evaluate(wi, wo)) == brighter


def test_an_opposition_surge_doubles_what_comes_back_at_most() -> None:
    up = np.array([[0.0, 0.0, 1.0]])
    # dark particles: what is scattered more than once does not count
    plain, surging = (Particulate(1e-6, 0.0, surge).evaluate(up, up) for surge in (0.0, 1.0))
    assert surging[0, 0] == pytest.approx(2.0 * plain[0, 0], rel=1e-5)


def test_dark_particles_are_lommel_and_seeligers_law(random_directions: Draw) -> None:
    wi, wo = random_directions(50)
    expected = 1e-6 / (4.0 * np.pi) / (wi[:, 2] + wo[:, 2])
    np.testing.assert_allclose(Particulate(1e-6).evaluate(wi, wo)[:, 0], expected, rtol=1e-5)


def test_particles_that_only_scatter_forward_are_refused() -> None:
    with pytest.raises(UsageError, match="asymmetry up to 1"):
        Particulate(0.5, 1.0)
