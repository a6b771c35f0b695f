"""A value that is zero or negative is a bound, as dark as its row lets it be."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.reconstruct import Posterior
from brdfit.reconstruct.posterior.measurements import Measurements, targets_of
from brdfit.reconstruct.targets import Targets


@pytest.fixture
def out_of_gamut(measure):
    """A material that is red near the mirror direction and less than black in red elsewhere."""
    samples = measure(n=200)
    value = samples.value.copy()
    off_peak = samples.half_diff[0] > np.median(samples.half_diff[0])
    value[off_peak, 0] = -0.3 * value[off_peak, 1]
    return samples.with_value(value), off_peak


def test_a_bound_is_the_largest_of_floor_own_size_and_share_of_the_row(out_of_gamut):
    samples, off_peak = out_of_gamut
    value = samples.value.copy()
    zero, dim = np.flatnonzero(off_peak)[:2]
    value[zero, 0] = 0.0
    value[dim] = [-1e-9, 1e-9, 1e-9]
    samples = samples.with_value(value)
    bound = np.exp(targets_of(samples).log_value[:, 0])
    size = np.maximum(-value[:, 0], 0.01 * value.max(axis=1))
    expected = np.where(off_peak, np.maximum(samples.noise_floor[0], size), value[:, 0])
    np.testing.assert_allclose(bound, expected)
    assert bound[dim] == pytest.approx(samples.noise_floor[0])


def test_bounds_alone_change(out_of_gamut):
    samples, _ = out_of_gamut
    plain, raised = Targets.of(samples), targets_of(samples)
    assert np.array_equal(plain.usable, raised.usable)
    assert np.array_equal(plain.censored, raised.censored)
    sure = ~plain.censored
    assert np.array_equal(plain.log_value[sure], raised.log_value[sure])


def test_a_row_without_a_brighter_channel_keeps_the_floor(measure):
    samples = measure(n=60)
    value = samples.value.copy()
    value[7] = 0.0
    samples = samples.with_value(value)
    np.testing.assert_allclose(targets_of(samples).log_value[7], np.log(samples.noise_floor))


def test_a_bound_that_is_respected_has_no_say(out_of_gamut):
    samples, off_peak = out_of_gamut
    data = Measurements.of(samples, 1e-5)
    told = data.y - np.where(data.censored, 0.1, 0.0)
    assert np.array_equal(data.informative(told), ~data.censored)
    assert data.censored.sum() == off_peak.sum()


def test_a_channel_outside_the_gamut_leaves_its_own_peak_and_the_others_alone(toy, out_of_gamut):
    samples, off_peak = out_of_gamut
    method = Posterior(population=toy.without(["m4"]), residual_size=200)
    result = method.fit(samples)
    green = samples.value[:, 1:]
    found = result.evaluate(samples.wi, samples.wo)
    assert np.median(np.abs(np.log(found[:, 1:] / green))) < 0.02
    red = np.abs(np.log(found[~off_peak, 0] / samples.value[~off_peak, 0]))
    assert np.median(red) < 0.05
    assert not result.outliers.any()
