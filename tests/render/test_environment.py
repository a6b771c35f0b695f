"""Panoramas: which way they hang, that drawing and density agree, and what a sphere shows."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.albedo import directional_albedo
from brdfit.arrays import normalize
from brdfit.errors import UsageError
from brdfit.models import Ggx, Lambert
from brdfit.render import Environment, Sphere, shade_under
from brdfit.render.lobe import Lobe


def spot(row: int, column: int, height: int = 16) -> np.ndarray:
    radiance = np.zeros((height, 2 * height, 3))
    radiance[row, column] = 1.0
    return radiance


@pytest.mark.parametrize(
    ("row", "column", "direction"),
    [
        (0, 7, (0.0, 1.0, 0.0)),
        (15, 7, (0.0, -1.0, 0.0)),
        (8, 16, (0.0, 0.0, -1.0)),
        (8, 24, (1.0, 0.0, 0.0)),
        (8, 8, (-1.0, 0.0, 0.0)),
        (8, 0, (0.0, 0.0, 1.0)),
    ],
)
def test_a_panorama_hangs_behind_the_sphere(
    row: int, column: int, direction: tuple[float, float, float]
) -> None:
    drawn = Environment("spot", spot(row, column)).draw(np.array([[0.5, 0.5]]))[0]
    assert drawn @ direction > 0.95


def test_turning_moves_the_middle_to_the_right() -> None:
    turned = Environment("spot", spot(8, 16), turned=np.pi / 2)
    assert turned.draw(np.array([[0.5, 0.5]]))[0, 0] > 0.95
    assert turned.look(np.array([[1.0, -0.05, 0.0]])).min() == 1.0


def test_what_is_drawn_is_as_frequent_as_the_density_says(rng: np.random.Generator) -> None:
    radiance = rng.uniform(0.0, 1.0, (8, 16, 3)) ** 4
    radiance[3] = 0.0
    environment = Environment("noise", radiance, turned=0.4)
    drawn = environment.draw(rng.random((40_000, 2)))
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1.0, rtol=1e-9)
    assert (environment.look(drawn).sum(axis=1) > 0.0).all()
    everywhere = normalize(rng.normal(size=(200_000, 3)))
    for axis in np.eye(3):
        share = np.mean(drawn @ axis > 0.3)
        integral = (
            4.0 * np.pi * np.mean(environment.density(everywhere) * (everywhere @ axis > 0.3))
        )
        assert share == pytest.approx(integral, abs=0.012)


@pytest.mark.parametrize("alpha", [0.03, 0.3])
def test_the_density_of_a_lobe_is_that_of_its_directions(
    alpha: float, rng: np.random.Generator
) -> None:
    lobe = Lobe.of(Ggx(diffuse=0.1, f0=0.5, alpha=alpha))
    wo = np.tile(normalize(np.array([0.5, 0.0, 0.8])), (60_000, 1))
    wi = lobe.draw(wo, rng.random((60_000, 2)))
    up = wi[:, 2] > 0.0
    # 1 / density, summed over what is drawn, is the solid angle of the hemisphere
    share = np.sum(1.0 / lobe.density(wi[up], wo[up])) / len(wo)
    assert share == pytest.approx(2.0 * np.pi, rel=0.05)


def test_a_white_furnace_shows_the_albedo() -> None:
    furnace = Environment("furnace", np.ones((8, 16, 3)))
    sphere = Sphere(12)
    for model in (Lambert([0.6, 0.3, 0.1]), Ggx([0.1, 0.2, 0.0], 0.6, 0.05)):
        image = shade_under(sphere, model, furnace, samples=512)[sphere.mask]
        theta = np.arccos(sphere.normal[:, 2])
        np.testing.assert_allclose(image, directional_albedo(model, theta), rtol=0.1, atol=0.01)


def test_a_lamp_on_the_left_lights_the_left_and_one_above_the_top() -> None:
    sphere = Sphere(24)
    left = shade_under(sphere, Lambert([0.5] * 3), Environment("left", spot(8, 8)), 32)[..., 0]
    above = shade_under(sphere, Lambert([0.5] * 3), Environment("above", spot(0, 0)), 32)[..., 0]
    assert left[:, :12].sum() > 20.0 * left[:, 12:].sum()
    assert above[:12].sum() > 20.0 * above[12:].sum()


def test_the_same_picture_every_time_and_less_noise_with_more_samples() -> None:
    sphere, lights = Sphere(12), Environment("spots", spot(3, 20) + 0.01)
    model = Ggx([0.3, 0.2, 0.1], 0.05, 0.1)
    fine = shade_under(sphere, model, lights, 4096)
    coarse = [shade_under(sphere, model, lights, n) for n in (16, 16, 256)]
    np.testing.assert_array_equal(coarse[0], coarse[1])
    errors = [np.sqrt(np.mean((image - fine) ** 2)) for image in coarse]
    assert errors[2] < 0.5 * errors[0]


@pytest.mark.parametrize("bad", [np.zeros((4, 8, 3)), np.full((4, 8, 3), -1.0), np.ones((4, 8))])
def test_what_is_no_light_is_refused(bad: np.ndarray) -> None:
    with pytest.raises(UsageError, match="environment 'bad'"):
        Environment("bad", bad)
