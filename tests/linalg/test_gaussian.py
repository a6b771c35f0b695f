"""Gaussian coefficients: the laws that a posterior obeys."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.linalg import CoefficientPosterior


@pytest.fixture
def problem():
    rng = np.random.default_rng(5)
    features = rng.normal(size=(30, 8))
    return features, rng.uniform(0.5, 4.0, 30), rng.normal(size=(30, 3))


def test_the_mean_minimises_the_penalised_squares(problem):
    features, weights, y = problem
    z = CoefficientPosterior.of(features, weights).solve(y)
    gradient = z - features.T @ (weights[:, None] * (y - features @ z))
    assert np.abs(gradient).max() < 1e-10


def test_what_is_left_out_is_what_a_fit_without_the_row_says(problem):
    features, weights, y = problem
    posterior = CoefficientPosterior.of(features, weights)
    found = posterior.left_out(y, features @ posterior.solve(y))
    for row in (0, 7, 29):
        without = weights.copy()
        without[row] = 0.0
        other = CoefficientPosterior.of(features, without)
        assert np.allclose(found.mean[row], features[row] @ other.solve(y), atol=1e-10)
        assert np.isclose(found.variance[row], other.variance(features[[row]])[0], atol=1e-10)


def test_a_row_twice_is_a_row_of_twice_the_weight(problem):
    features, weights, y = problem
    twice = CoefficientPosterior.of(np.tile(features, (2, 1)), np.tile(weights, 2) / 2.0)
    one = CoefficientPosterior.of(features, weights)
    assert np.allclose(one.solve(y), twice.solve(np.tile(y, (2, 1))), atol=1e-12)


def test_entries_that_are_missing_have_no_say(problem):
    features, weights, y = problem
    known = np.random.default_rng(6).random(y.shape) > 0.4
    wild = np.where(known, y, 1e6)
    z = CoefficientPosterior.of(features, weights).solve(wild, known)
    for channel in range(3):
        own = CoefficientPosterior.of(features, weights * known[:, channel])
        assert np.allclose(z[:, [channel]], own.solve(y[:, [channel]]), atol=1e-7)


def test_rows_of_no_weight_leave_the_prior(problem):
    features, _, y = problem
    posterior = CoefficientPosterior.of(features, np.zeros(30))
    assert np.array_equal(posterior.solve(y), np.zeros((8, 3)))
    assert np.allclose(posterior.variance(features), (features**2).sum(axis=1))


def test_where_the_search_begins_does_not_matter(problem):
    features, weights, y = problem
    posterior = CoefficientPosterior.of(features, weights)
    known = np.random.default_rng(7).random(y.shape) > 0.3
    known[:, 0] = True
    plain = posterior.solve(y, known)
    begun = posterior.solve(y, known, start=np.random.default_rng(8).normal(size=plain.shape))
    assert np.allclose(plain, begun, atol=1e-7)
    assert np.allclose(plain[:, 0], posterior.solve(y)[:, 0])
