"""Scattered-data interpolation: exact at the samples, in coordinates that respect symmetry."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.errors import FitError
from brdfit.geometry import directions_from_spherical, half_diff_from_directions
from brdfit.reconstruct import Tabulated
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.samples import Samples

KERNELS = ["linear", "thin_plate_spline", "cubic"]


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("n", [40, 300])  # fewer and more than the neighbours
def test_it_is_exact_at_the_samples(measure, kernel, n):
    samples = measure(n=n)
    result = Tabulated(kernel=kernel).fit(samples)
    assert np.allclose(result.evaluate(samples.wi, samples.wo), samples.value, rtol=1e-5)
    assert np.abs(result.residuals).max() < 1e-4
    assert not result.outliers.any()


def test_measurements_of_the_same_place_are_averaged(measure):
    samples = measure(n=100)
    # the first ten again: as they are, and with light and detector exchanged
    wi = np.vstack([samples.wi, samples.wi[:5], samples.wo[5:10]])
    wo = np.vstack([samples.wo, samples.wo[:5], samples.wi[5:10]])
    value = np.vstack([samples.value, 3.0 * samples.value[:10]])
    result = Tabulated().fit(Samples(wi=wi, wo=wo, value=value))
    found = result.evaluate(samples.wi, samples.wo)
    assert np.allclose(found[:10], 2.0 * samples.value[:10], rtol=1e-5)
    assert np.allclose(found[10:], samples.value[10:], rtol=1e-5)


def test_zeros_and_negatives_are_interpolated_and_held_above_zero(measure):
    samples = measure(n=100)
    value = samples.value.copy()
    value[3], value[4] = 0.0, -0.2
    result = Tabulated().fit(samples.with_value(value))
    found = result.evaluate(samples.wi[3:5], samples.wo[3:5])
    assert np.allclose(found, 1e-6)


@pytest.mark.parametrize("kernel", KERNELS)
def test_measurements_in_one_plane_are_interpolated_or_refused_in_words(kernel):
    theta_i, theta_o = np.meshgrid(np.radians([5.0, 25.0, 45.0]), np.radians(np.arange(8, 80, 4)))
    wi = directions_from_spherical(theta_i.ravel(), np.zeros(theta_i.size))
    wo = directions_from_spherical(theta_o.ravel(), np.full(theta_o.size, np.pi))
    value = 0.2 + np.exp(-20.0 * (theta_i - theta_o).ravel() ** 2)
    samples = Samples(wi=wi, wo=wo, value=value)
    if kernel == "linear":
        found = Tabulated(kernel=kernel).fit(samples).evaluate(wi, wo)[:, 0]
        assert np.allclose(found, value, rtol=1e-5)
    else:
        with pytest.raises(FitError, match=f"{kernel}.*Use kernel linear"):
            Tabulated(kernel=kernel).fit(samples)


def test_features_tell_directions_apart_but_not_their_symmetries(random_directions, rng):
    wi, wo = random_directions(100)
    features = half_diff_features(*half_diff_from_directions(wi, wo))
    swapped = half_diff_features(*half_diff_from_directions(wo, wi))
    assert np.allclose(features, swapped)
    distance = np.linalg.norm(features[:, None] - features[None], axis=-1)
    assert distance[~np.eye(100, dtype=bool)].min() > 1e-4
    theta = rng.uniform(0.0, np.pi / 2, 20)
    phi = rng.uniform(0.0, 2.0 * np.pi, 20)
    for pole in (
        half_diff_features(np.zeros(20), theta, phi),
        half_diff_features(theta, np.zeros(20), phi),
    ):
        assert np.allclose(pole[:, 2:], 0.0)
