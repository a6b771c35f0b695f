"""The material ball, and lights that are turned about it."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.models import Lambert
from brdfit.render import MaterialBall, Sphere, point, studio


def test_its_normals_are_of_unit_length_and_face_the_viewer() -> None:
    ball = MaterialBall(64)
    assert ball.normal.shape == (int(ball.mask.sum()), 3)
    np.testing.assert_allclose(np.linalg.norm(ball.normal, axis=1), 1.0)
    assert (ball.normal[:, 2] > 0.0).all()


@pytest.mark.parametrize("size", [17, 64, 200])
def test_it_has_no_holes_but_stands_apart_from_the_sides(size: int) -> None:
    mask = MaterialBall(size).mask
    for row in mask[mask.any(axis=1)]:
        seen = np.flatnonzero(row)
        assert row[seen[0] : seen[-1] + 1].all()
    assert not mask[:, 0].any()
    assert not mask[:, -1].any()


def test_upright_its_upper_part_is_the_sphere_that_it_is_made_of() -> None:
    size = 200
    ball = MaterialBall(size, tilt=0.0)
    normals = np.full((size, size, 3), np.nan)
    normals[ball.mask] = ball.normal
    middle = (2.0 * np.arange(size) + 1.0) / size - 1.0
    x, y = np.meshgrid(middle, -middle)
    across, along = x / 0.74, (y - 0.24) / 0.74
    inside = (across**2 + along**2 < 0.9**2) & (along > 0.0)
    expected = np.stack([across, along, np.sqrt(np.maximum(1.0 - across**2 - along**2, 0))], -1)
    # the nearest point of a pixel, not its middle, was taken
    np.testing.assert_allclose(normals[inside], expected[inside], atol=0.03)


def test_it_is_shaded_as_a_sphere_is() -> None:
    ball, white = MaterialBall(48), Lambert(np.ones(3))
    image = ball.shade(white, point())
    direction = point().direction[0]
    expected = np.maximum(ball.normal @ direction, 0.0) / np.pi
    np.testing.assert_allclose(image[ball.mask][:, 0], expected, atol=1e-6)
    assert (image[~ball.mask] == 0.0).all()


def test_lights_that_are_turned_turn_the_picture_of_a_sphere() -> None:
    class Lobe:
        def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
            half = wi + wo
            return (half[:, 2:] / np.linalg.norm(half, axis=1, keepdims=True)) ** 60

    sphere = Sphere(40)
    about = studio().turned(0.0, 0.0)
    np.testing.assert_allclose(about.direction, studio().direction)
    turned = point().turned(0.7, 0.3)
    np.testing.assert_allclose(np.linalg.norm(turned.direction, axis=1), 1.0)
    back = turned.turned(0.0, -0.3).turned(-0.7)
    np.testing.assert_allclose(back.direction, point().direction, atol=1e-12)
    # a light up and to the left goes to the right with the turn about the vertical
    half = point().turned(np.pi / 3)
    left, right = (
        np.unravel_index(sphere.shade(Lobe(), one)[..., 0].argmax(), (40, 40))[1]
        for one in (point(), half)
    )
    assert left < 20 < right
