"""What sets `Posterior` apart: it judges samples by one another, and says how sure it is."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from brdfit.errors import SampleError
from brdfit.grid import Grid
from brdfit.reconstruct import Posterior
from brdfit.reconstruct.posterior.principal import axes_of
from brdfit.reconstruct.posterior.prior import population_prior
from brdfit.reconstruct.posterior.residual import LocalResidual, Scale


@pytest.fixture
def method(toy):
    return Posterior(population=toy.without(["m4"]), residual_size=200)


def spoilt(samples, rows, factor):
    value = samples.value.copy()
    value[rows] *= factor
    return samples.with_value(value)


def off(one, other):
    return np.abs(np.log(one) - np.log(other))


def test_planted_outliers_are_named_and_move_little(method, measure):
    samples = measure(n=200)
    wrong = np.arange(0, 200, 4)
    result = method.fit(spoilt(samples, wrong, np.where(wrong % 8, 8.0, 0.1)[:, None]))
    named = np.flatnonzero(result.outliers)
    assert set(wrong) <= set(named)
    assert len(named) <= 1.1 * len(wrong)
    clean = method.fit(samples)
    assert np.median(off(result.evaluate(*samples.safe_directions), samples.value)) < 0.05
    assert np.median(off(clean.evaluate(*samples.safe_directions), samples.value)) < 0.05


def test_a_lobe_that_no_member_has_is_material(method, measure):
    samples = measure(n=400)
    theta_h = samples.half_diff[0]
    lobe = 1.0 + 6.0 * np.exp(-((theta_h - 0.6) ** 2) / 0.02)
    result = method.fit(samples.with_value(samples.value * lobe[:, None]))
    inside = lobe > 3.0
    assert inside.sum() > 10
    assert result.outliers[inside].mean() < 0.2


def test_the_order_of_samples_changes_nothing(method, measure):
    samples = measure()
    order = np.random.default_rng(3).permutation(len(samples))
    one, other = method.fit(samples), method.fit(samples.subset(order))
    assert np.array_equal(one.weights[order], other.weights)
    assert np.array_equal(
        one.evaluate(samples.wi, samples.wo), other.evaluate(samples.wi, samples.wo)
    )


def test_a_fit_is_the_same_to_the_bit_when_it_is_repeated(method, measure):
    samples = measure()
    one, other = method.fit(samples).table(Grid(6, 5, 8)), method.fit(samples).table(Grid(6, 5, 8))
    assert np.array_equal(one.values, other.values)


def test_it_is_surer_where_it_was_measured(method, measure):
    samples = measure()
    near = samples.half_diff[0] < 0.4
    result = method.fit(samples.subset(near))
    deviation = result.stddev(samples.wi, samples.wo)
    assert deviation.shape == samples.value.shape
    assert np.median(deviation[near]) < np.median(deviation[~near])


def test_more_samples_than_the_search_looks_at_all_count(method, measure):
    samples = measure(n=3200)
    result = method.fit(spoilt(samples, np.arange(0, 3200, 5), 9.0))
    assert result.outliers[::5].mean() > 0.9
    assert result.outliers.mean() < 0.25


def test_too_many_samples_are_refused_in_words(method, measure, monkeypatch):
    monkeypatch.setattr("brdfit.reconstruct.posterior.method._MOST_SAMPLES", 100)
    with pytest.raises(SampleError, match="at most 100"):
        method.fit(measure(n=150))


def test_a_stated_sigma_lowers_the_say_of_a_sample(method, measure):
    samples = measure(n=60)
    value = samples.value.copy()
    value[0] *= 1.2
    wide = np.full(value.shape, 1e-4)
    wide[0] = value[0]
    unsure = dataclasses.replace(samples, value=value, sigma=wide)
    sure = dataclasses.replace(samples, value=value, sigma=np.full(value.shape, 1e-4))
    at = samples.wi[:1], samples.wo[:1]
    truth = samples.value[:1]
    assert off(method.fit(unsure).evaluate(*at), truth).max() <= (
        off(method.fit(sure).evaluate(*at), truth).max() + 1e-3
    )


def test_components_give_the_columns_back():
    logs = np.random.default_rng(2).normal(size=(60, 6))
    axes = axes_of(logs, 1e-14)
    mean = logs.mean(axis=1, keepdims=True)
    assert np.allclose(mean + (logs - mean) @ axes @ axes.T, logs, atol=1e-6)


def test_the_prior_has_the_mean_and_the_covariance_of_the_weighted_columns():
    axes = np.random.default_rng(4).normal(size=(9, 4))
    weights = np.arange(9.0)
    prior = population_prior(axes, weights)
    assert np.allclose(prior.mean, np.average(axes, axis=0, weights=weights))
    expected = np.cov(axes.T, aweights=weights, ddof=0)
    assert np.allclose(prior.factor @ prior.factor.T, expected)


def test_the_residual_on_axes_is_the_residual_at_the_nodes():
    residual = LocalResidual.of(Scale(0.2, 0.3, 120))
    z = np.random.default_rng(5).normal(size=(residual.size, 2))
    grid = Grid(5, 4, 6)
    dense = residual.on_axes(z, grid.theta_h, grid.theta_d, grid.phi_d)
    at_nodes = residual.at(grid.half_diff(np.arange(grid.size))) @ z
    assert np.allclose(dense.reshape(-1, 2), at_nodes, atol=1e-4)


def test_the_residual_is_reciprocal_and_knows_no_azimuth_at_the_poles():
    residual = LocalResidual.of(Scale())
    angle = np.array([0.3, 0.7, 1.1])
    one = residual.at((angle, angle, angle))
    assert np.allclose(one, residual.at((angle, angle, angle + np.pi)))
    for pole in ((angle * 0.0, angle, angle), (angle, angle * 0.0, angle)):
        turned = (pole[0], pole[1], angle + 0.5)
        assert np.allclose(residual.at(pole), residual.at(turned), atol=1e-6)


def test_the_leading_directions_are_the_largest_in_ln_f_r_and_the_prior_is_the_same():
    rng = np.random.default_rng(8)
    sizes = np.array([30.0, 1.0, 0.1, 0.01])
    axes = np.linalg.qr(rng.normal(size=(12, 4)))[0]
    components = np.hstack([np.zeros((50, 1)), rng.normal(size=(50, 4)) * sizes])
    weights = rng.random(12)
    plain, ordered = population_prior(axes, weights), population_prior(axes, weights, sizes)
    assert np.allclose(plain.factor @ plain.factor.T, ordered.factor @ ordered.factor.T)
    variance = (ordered.features(components)[:, :-1] ** 2).sum(axis=0)
    assert variance[0] > 0.9 * variance.sum()
    assert np.allclose(ordered.leading(1).factor, ordered.factor[:, :1])
