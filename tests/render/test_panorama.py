"""A panorama as distant lights."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.models import Lambert
from brdfit.render import Sphere, panorama_lights


def test_no_light_is_lost_and_an_even_sky_lights_a_lambertian_evenly() -> None:
    lights = panorama_lights(np.ones((64, 128, 3)))
    np.testing.assert_allclose(lights.irradiance.sum(axis=0), 4.0 * np.pi, rtol=1e-9)
    image = Sphere(32).shade(Lambert(np.ones(3)), lights)
    # irradiance pi under radiance 1, times 1 / pi
    np.testing.assert_allclose(image[Sphere(32).mask], 1.0, atol=0.02)


@pytest.mark.parametrize(
    ("row", "column", "toward"),
    [
        (0, 10, (0.0, 1.0, 0.0)),
        (32, 64, (0.0, 0.0, -1.0)),
        (32, 96, (1.0, 0.0, 0.0)),
        (32, 0, (0.0, 0.0, 1.0)),
    ],
)
def test_a_small_sun_stays_where_it_is(
    row: int, column: int, toward: tuple[float, float, float]
) -> None:
    image = np.zeros((64, 128, 3))
    image[row, column] = (1000.0, 900.0, 800.0)
    lights = panorama_lights(image)
    assert len(lights) == 1
    np.testing.assert_allclose(lights.direction[0], toward, atol=0.05)
    np.testing.assert_allclose(lights.irradiance[0, 1] / lights.irradiance[0, 0], 0.9)


def test_what_is_not_finite_or_negative_gives_no_light() -> None:
    image = np.ones((24, 48, 3))
    image[3, 4] = np.nan
    image[5, 6] = -10.0
    image[7, 8] = np.inf
    lights = panorama_lights(image)
    assert np.isfinite(lights.irradiance).all()
    assert lights.irradiance.min() >= 0.0


@pytest.mark.parametrize("shape", [(64, 128), (64, 128, 4), (4, 8, 3)])
def test_what_is_no_panorama_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(UsageError, match="a panorama has three channels"):
        panorama_lights(np.ones(shape))


def test_the_dark_is_refused() -> None:
    with pytest.raises(UsageError, match="is black"):
        panorama_lights(np.zeros((64, 128, 3)))
