"""Laws of shading, and what can be computed by hand."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.grid import Grid
from brdfit.render import ILLUMINATIONS, Illumination, Sphere, SphereView, area_studio, studio
from brdfit.table import Table

COARSE = Grid(20, 18, 24)


class Lambert:
    def __init__(self, *albedo: float) -> None:
        self.albedo = np.array(albedo)

    def evaluate(self, wi, wo):
        return np.broadcast_to(self.albedo / np.pi, (len(wi), len(self.albedo)))


class Lobe:
    """Reciprocal and glossy, three different channels."""

    def evaluate(self, wi, wo):
        half = wi + wo
        cosine = half[:, 2] / np.linalg.norm(half, axis=1)
        return cosine[:, None] ** np.array([5.0, 20.0, 80.0]) + 0.1


def one_light(direction, irradiance=(1.0, 1.0, 1.0)):
    return Illumination("test", np.array([direction], dtype=float), np.array([irradiance]))


def table_of(brdf, grid):
    wi, wo = grid.directions(grid.cells)
    value = np.zeros((grid.size, 3))
    value[grid.cells] = brdf.evaluate(wi, wo)
    return Table(values=value.reshape(*grid.shape, 3), grid=grid)


def test_a_lambert_sphere_under_one_light_is_albedo_over_pi_times_cosine_times_irradiance():
    sphere, toward = Sphere(32), np.array([0.6, 0.0, 0.8])
    image = sphere.shade(Lambert(0.2, 0.5, 0.9), one_light(toward, (2.0, 3.0, 4.0)))
    cosine = np.maximum(sphere.normal @ toward, 0.0)
    expected = cosine[:, None] * np.array([0.2 * 2.0, 0.5 * 3.0, 0.9 * 4.0]) / np.pi
    np.testing.assert_allclose(image[sphere.mask], expected, atol=1e-6)
    assert np.all(image[~sphere.mask] == 0.0)


def test_light_from_above_left_brightens_the_rows_above_and_the_columns_left():
    image = Sphere(32).shade(Lambert(1.0), one_light((-1.0, 1.0, 0.5)))[..., 0]
    assert image[:16].sum() > 2.0 * image[16:].sum()
    assert image[:, :16].sum() > 2.0 * image[:, 16:].sum()


def test_a_highlight_is_where_the_half_vector_is_the_normal():
    sphere, toward = Sphere(64), np.array([0.48, 0.64, 0.6])
    image = sphere.shade(Lobe(), one_light(toward))[..., 2]
    # the cosine pulls the brightest pixel toward the light, by less than the tolerance
    row, column = np.unravel_index(np.argmax(image), image.shape)
    half = toward + np.array([0.0, 0.0, 1.0])
    half /= np.linalg.norm(half)
    expected = ((half[0] + 1.0) * 32 - 0.5, (1.0 - half[1]) * 32 - 0.5)
    assert column == pytest.approx(expected[0], abs=2.5)
    assert row == pytest.approx(expected[1], abs=2.5)


def test_shading_is_linear_in_the_brdf():
    class Sum:
        def evaluate(self, wi, wo):
            return 2.0 * Lambert(1, 1, 1).evaluate(wi, wo) + 3.0 * Lobe().evaluate(wi, wo)

    sphere, light = Sphere(16), studio()
    apart = 2.0 * sphere.shade(Lambert(1, 1, 1), light) + 3.0 * sphere.shade(Lobe(), light)
    np.testing.assert_allclose(sphere.shade(Sum(), light), apart, rtol=1e-12)


def test_shading_adds_over_lights():
    light = studio()
    first = Illumination("a", light.direction[:13], light.irradiance[:13])
    rest = Illumination("b", light.direction[13:], light.irradiance[13:])
    sphere = Sphere(16)
    together = sphere.shade(Lobe(), light)
    np.testing.assert_allclose(
        together, sphere.shade(Lobe(), first) + sphere.shade(Lobe(), rest), rtol=1e-12
    )


def test_turning_the_lights_by_a_right_angle_about_the_view_turns_the_image():
    light = studio()
    x, y, z = light.direction.T
    turned = Illumination("turned", np.stack([-y, x, z], axis=1), light.irradiance)
    sphere = Sphere(24)
    np.testing.assert_allclose(
        sphere.shade(Lobe(), turned), np.rot90(sphere.shade(Lobe(), light)), atol=1e-12
    )


def test_monochrome_values_are_lit_by_the_luminance_of_the_light():
    image = Sphere(16).shade(Lambert(0.5), one_light((0, 0, 1), (1.0, 2.0, 3.0)))
    middle = image[8, 8, 0]
    normal_z = np.sqrt(1.0 - 2.0 * (1.0 / 16.0) ** 2)
    luminance = 0.2126 * 1.0 + 0.7152 * 2.0 + 0.0722 * 3.0
    assert image.shape == (16, 16, 1)
    assert middle == pytest.approx(0.5 / np.pi * luminance * normal_z)


def test_what_the_sphere_asks_are_unit_vectors_above_the_horizon_of_the_surface():
    sphere, light = Sphere(17), studio()
    asked = sphere.directions(light)
    np.testing.assert_allclose(np.linalg.norm(asked.wi, axis=1), 1.0)
    np.testing.assert_allclose(np.linalg.norm(asked.wo, axis=1), 1.0)
    assert asked.wi[:, 2].min() > 0.0
    assert asked.wo[:, 2].min() > 0.0
    # angles between light and viewer do not depend on the frame
    between = light.direction[asked.light][:, 2]
    np.testing.assert_allclose(np.sum(asked.wi * asked.wo, axis=1), between, atol=1e-12)
    lit = (sphere.normal @ light.direction.T > 1e-6).sum()
    assert len(asked.pixel) == lit


def test_a_chunk_at_a_time_gives_the_image_of_all_at_once(monkeypatch):
    sphere, light = Sphere(20), studio()
    whole = sphere.shade(Lobe(), light)
    monkeypatch.setattr("brdfit.render.sphere._CHUNK", 40 * 7)
    np.testing.assert_allclose(sphere.shade(Lobe(), light), whole, rtol=1e-13)


@pytest.mark.parametrize("channels", [3, 1])
def test_the_view_agrees_with_direct_shading(channels):
    sphere, light = Sphere(24), studio()
    brdf = Lobe() if channels == 3 else Lambert(0.5)
    view = SphereView.build(sphere, light)
    values = brdf.evaluate(view.queries.wi, view.queries.wo)
    assert values.shape == (len(view), channels)
    direct = sphere.shade(brdf, light)
    np.testing.assert_allclose(view.shade(values), direct, rtol=1e-12, atol=1e-14)
    assert direct.max() > 0.1


def test_the_view_refuses_values_that_are_not_one_row_a_direction():
    view = SphereView.build(Sphere(8), studio())
    with pytest.raises(UsageError, match=f"asks for {len(view)} directions"):
        view.shade(np.ones((len(view) + 1, 3)))


def test_the_studio_has_the_constants_of_its_definition():
    light = studio()
    assert len(light) == 40
    np.testing.assert_allclose(np.linalg.norm(light.direction, axis=1), 1.0)
    np.testing.assert_allclose(light.direction[0], [np.sqrt(1 - 0.975**2), 0.975, 0.0])
    keys = np.flatnonzero(light.irradiance[:, 0] != light.irradiance[:, 2])
    assert keys.tolist() == [0, 18, 24, 29, 31]
    np.testing.assert_allclose(light.irradiance[1], 0.15 * (1 + 0.5 * (1 - 3 / 40)))
    first = 0.15 * (1 + 0.5 * 0.975)
    np.testing.assert_allclose(light.irradiance[0], [first + 1.5, first + 1.4, first + 1.2])


def test_every_built_in_illumination_gives_light_from_unit_directions():
    for name, build in ILLUMINATIONS.items():
        light = build()
        assert light.name == name
        np.testing.assert_allclose(np.linalg.norm(light.direction, axis=1), 1.0)
        assert light.irradiance.min() >= 0.0
        assert light.irradiance.max() > 0.0


def test_a_finer_area_studio_lights_a_matte_sphere_the_same():
    coarse, fine = area_studio(0.1), area_studio(0.03)
    assert len(fine) > 4 * len(coarse)
    sphere, matte = Sphere(16), Lambert(0.5, 0.5, 0.5)
    a, b = sphere.shade(matte, coarse), sphere.shade(matte, fine)
    np.testing.assert_allclose(a, b, rtol=2e-2, atol=2e-3 * b.max())


def test_a_view_refuses_a_surround_and_says_what_to_use():
    with pytest.raises(UsageError, match=r"'area_studio' has a surround .* Sphere\.shade"):
        SphereView.build(Sphere(8), area_studio())


def test_shading_tells_its_progress_from_the_first_pixel_to_the_last():
    heard = []
    sphere = Sphere(16)
    sphere.shade(Lambert(0.5), studio(), lambda *told: heard.append(told))
    assert heard[0] == ("shading", 0, len(sphere.normal))
    assert heard[-1] == ("shading", len(sphere.normal), len(sphere.normal))
