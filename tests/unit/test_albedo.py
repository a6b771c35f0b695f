"""The furnace: what reflects all of an even surround vanishes in it."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.albedo import albedo_rule, directional_albedo
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical, half_diff_from_directions
from brdfit.models import Ggx
from brdfit.render import Illumination, Sphere

THETA = np.radians([0.0, 20.0, 45.0, 60.0, 75.0, 85.0, 89.0])


class Lambert:
    def evaluate(self, wi, wo):
        return np.full((len(wi), 3), 1.0 / np.pi)


class NarrowLobe:
    """A lobe about the mirror direction whose integral with the cosine is known.

    f = exp(-(psi / s)^2) / (pi s^2 cos theta_o): pi s^2 is the lobe's solid angle.
    """

    def __init__(self, width: float) -> None:
        self.width = width

    def evaluate(self, wi, wo):
        mirror = wi * np.array([-1.0, -1.0, 1.0])
        psi = 2.0 * np.arcsin(np.clip(np.linalg.norm(wo - mirror, axis=1) / 2.0, 0.0, 1.0))
        lobe = np.exp(-((psi / self.width) ** 2)) / (np.pi * self.width**2)
        return (lobe / wo[:, 2])[:, None]


def test_a_white_lambert_surface_reflects_everything():
    np.testing.assert_allclose(directional_albedo(Lambert(), THETA), 1.0, rtol=1e-5)


@pytest.mark.parametrize("degrees", [0.1, 0.5, 2.0])
def test_a_lobe_is_not_missed_however_narrow(degrees):
    albedo = directional_albedo(NarrowLobe(np.deg2rad(degrees)), THETA[:5])
    np.testing.assert_allclose(albedo, 1.0, rtol=0.01)


@pytest.mark.parametrize("alpha", [0.05, 0.3])
def test_the_rule_agrees_with_brute_force_over_directions(alpha):
    model = Ggx(diffuse=[0.0, 0.3], f0=0.6, alpha=alpha)
    theta, phi = np.radians(50.0), np.linspace(-np.pi, np.pi, 1201)
    x, share = np.polynomial.legendre.leggauss(800)
    cosine = (x + 1.0) / 2.0
    wo = directions_from_spherical(np.arccos(cosine)[:, None], 0.5 * (phi[1:] + phi[:-1]))
    wi = np.broadcast_to(directions_from_spherical(theta, 0.0), wo.shape).reshape(-1, 3)
    value = model.evaluate(wi, wo.reshape(-1, 3)).reshape(*wo.shape[:2], 2)
    expected = np.einsum("ij...,i,i->...", value, cosine, share / 2.0) * 2.0 * np.pi / 1200
    np.testing.assert_allclose(directional_albedo(model, theta)[0], expected, rtol=2e-4)


def test_the_rule_sees_both_sides_of_the_plane_of_incidence():
    class OneSided:
        def evaluate(self, wi, wo):
            _, _, phi_d = half_diff_from_directions(wi, wo)
            return np.where(phi_d < np.pi, 2.0 / np.pi, 0.0)[:, None]

    np.testing.assert_allclose(directional_albedo(OneSided(), THETA[1:]), 1.0, rtol=1e-4)


def test_every_direction_of_the_rule_is_above_the_horizon_and_unit():
    for theta in THETA:
        wi, wo, weight = albedo_rule(theta)
        assert wi == pytest.approx([np.sin(theta), 0.0, np.cos(theta)])
        assert (wo[:, 2] > 0.0).all()
        assert (weight > 0.0).all()
        np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("theta", [-0.1, np.pi / 2, 45.0, np.nan, [[0.1]]])
def test_an_angle_that_is_no_incidence_is_refused(theta):
    with pytest.raises(UsageError, match="radians"):
        directional_albedo(Lambert(), theta)


def test_a_white_sphere_in_an_even_surround_has_the_radiance_of_the_surround():
    furnace = Illumination("furnace", np.array([[0.0, 0, 1]]), np.zeros((1, 3)), (0.5, 0.6, 0.7))
    sphere = Sphere(24)
    image = sphere.shade(Lambert(), furnace)
    np.testing.assert_allclose(
        image[sphere.mask], np.broadcast_to([0.5, 0.6, 0.7], (sphere.mask.sum(), 3)), rtol=1e-4
    )
