"""Samples scatter more in some places than in others, and `Posterior` says so."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.geometry import directions_from_spherical
from brdfit.reconstruct import Posterior
from brdfit.reconstruct.posterior.places import places

STEEP = 78.0


@pytest.fixture
def method(toy):
    return Posterior(population=toy.without(["m4"]), residual_size=400)


def polar(samples):
    return np.degrees(np.arccos(np.minimum(samples.wi[:, 2], samples.wo[:, 2])))


def uneven(samples, seed, low=0.02, high=0.1):
    """Scatter all channels alike: by `low` in ln f_r, rising to `high` about `STEEP` degrees."""
    rng = np.random.default_rng(seed)
    size = np.interp(polar(samples), (STEEP - 8.0, STEEP + 4.0), (low, high))
    return samples.with_value(samples.value * np.exp(size * rng.normal(size=len(samples)))[:, None])


def test_places_are_reciprocal_blind_to_phi_and_sum_to_two(rng):
    theta = rng.uniform(0.0, 1.55, (2, 50))
    phi = rng.uniform(-np.pi, np.pi, (2, 50))
    wi, wo = directions_from_spherical(theta, phi)
    turned = directions_from_spherical(theta, phi + 1.0)
    found = places(wi, wo)
    np.testing.assert_allclose(found, places(wo, wi), atol=1e-12)
    np.testing.assert_allclose(found, places(*turned), atol=1e-9)
    np.testing.assert_allclose(found.sum(axis=1), 2.0)
    assert found.min() >= 0.0


def test_scatter_near_grazing_is_stated_there_and_nobody_is_called_wrong(method, measure):
    clean = measure(n=400, noise=0.0)
    result = method.fit(uneven(clean, 5))
    assert result.outliers.mean() < 0.02
    new = measure(n=300, noise=0.0, seed=9)
    value = uneven(new, 6).value
    stated = np.hypot(result.stddev(new.wi, new.wo), result.history[-1]["noise"])
    beyond = polar(new) > STEEP
    assert np.median(stated[beyond]) > 1.5 * np.median(stated[~beyond])
    z = np.abs(np.log(value / result.evaluate(new.wi, new.wo))) / stated
    assert (z[beyond] < result.deviations(0.95)).mean() > 0.85


def test_an_even_scatter_is_stated_as_such(method, measure):
    result = method.fit(measure(n=400, noise=0.03))
    belief = result.model.winner.explanation.belief
    new = measure(n=300, seed=9)
    factor = belief.unevenness.factor(places(new.wi, new.wo))
    assert factor.min() > 0.3
    assert factor.max() < 3.0


def test_planted_outliers_near_grazing_are_still_told(method, measure):
    samples = uneven(measure(n=400, noise=0.0), 5)
    wrong = np.flatnonzero(polar(samples) > STEEP)[::4]
    value = samples.value.copy()
    value[wrong] *= 8.0
    result = method.fit(samples.with_value(value))
    assert result.outliers[wrong].mean() > 0.9
    others = np.setdiff1d(np.arange(400), wrong)
    assert result.outliers[others].mean() < 0.03
