"""Where peaks and poles stand in the slices."""

from __future__ import annotations

import numpy as np

from brdfit.geometry import half_diff_from_directions
from brdfit.render import half_difference_image, incidence_slices


class Lobe:
    def evaluate(self, wi, wo):
        theta_h, _, _ = half_diff_from_directions(wi, wo)
        return np.exp(-((theta_h / 0.1) ** 2))[:, None]


class DifferenceAngle:
    def evaluate(self, wi, wo):
        assert min(wi[:, 2].min(), wo[:, 2].min()) > 0.0
        theta_h, theta_d, _ = half_diff_from_directions(wi, wo)
        return np.stack([theta_h, theta_d], axis=1)


def test_the_peak_of_each_slice_stands_at_the_mirror_direction():
    slices = incidence_slices(Lobe())
    peak = slices.theta_o[np.argmax(slices.values[..., 0], axis=1)]
    np.testing.assert_allclose(np.rad2deg(peak), [0, 15, 30, 45, 60, 75], atol=0.51)
    assert slices.values.shape == (6, 179, 1)


def test_slices_stay_above_the_horizon():
    slices = incidence_slices(DifferenceAngle(), theta_i=(0.0, 80.0), samples=41)
    assert np.abs(slices.theta_o).max() < np.pi / 2


def test_the_image_slice_has_theta_h_to_the_right_and_theta_d_upward():
    image = half_difference_image(DifferenceAngle(), size=6)
    middle = (np.arange(6) + 0.5) / 6 * np.pi / 2
    np.testing.assert_allclose(image[..., 0], np.broadcast_to(middle, (6, 6)), atol=1e-9)
    np.testing.assert_allclose(image[:, 0, 1], middle[::-1], atol=1e-9)
