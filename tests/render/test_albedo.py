"""The furnace: what reflects all of an even surround vanishes in it."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.render import Illumination, Sphere, directional_albedo


class Lambert:
    def evaluate(self, wi, wo):
        return np.full((len(wi), 3), 1.0 / np.pi)


class NarrowLobe:
    """A lobe about the mirror direction whose integral with the cosine is known.

    f = exp(-(psi / s)^2) / (pi s^2 cos theta_i): pi s^2 is the lobe's solid angle.
    """

    def __init__(self, width: float) -> None:
        self.width = width

    def evaluate(self, wi, wo):
        mirror = wo * np.array([-1.0, -1.0, 1.0])
        psi = 2.0 * np.arcsin(np.clip(np.linalg.norm(wi - mirror, axis=1) / 2.0, 0.0, 1.0))
        lobe = np.exp(-((psi / self.width) ** 2)) / (np.pi * self.width**2)
        return (lobe / wi[:, 2])[:, None]


def test_a_white_lambert_surface_reflects_everything():
    albedo = directional_albedo(Lambert(), np.linspace(0.05, 1.0, 9))
    np.testing.assert_allclose(albedo, 1.0, rtol=0.02)


@pytest.mark.parametrize("degrees", [0.5, 2.0, 8.0])
def test_a_lobe_is_not_missed_however_narrow(degrees):
    albedo = directional_albedo(NarrowLobe(np.deg2rad(degrees)), np.array([0.5, 0.8, 1.0]))
    np.testing.assert_allclose(albedo, 1.0, rtol=0.015)


def test_a_white_sphere_in_an_even_surround_has_the_radiance_of_the_surround():
    furnace = Illumination("furnace", np.array([[0.0, 0, 1]]), np.zeros((1, 3)), (0.5, 0.6, 0.7))
    sphere = Sphere(24)
    image = sphere.shade(Lambert(), furnace)
    np.testing.assert_allclose(
        image[sphere.mask], np.broadcast_to([0.5, 0.6, 0.7], (sphere.mask.sum(), 3)), rtol=0.02
    )
