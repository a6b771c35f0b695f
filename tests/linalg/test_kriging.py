"""Gaussian processes by covariance: the same answers as by coefficients, and the same laws."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.linalg import CoefficientPosterior, CovariancePosterior


@pytest.fixture
def problem():
    rng = np.random.default_rng(5)
    features = rng.normal(size=(20, 30))
    return features, rng.uniform(0.5, 4.0, 20), rng.normal(size=(20, 3))


def both(features, weights):
    return (
        CoefficientPosterior.of(features, weights),
        CovariancePosterior.of(features @ features.T, weights),
    )


def test_covariance_and_coefficients_say_the_same(problem):
    features, weights, y = problem
    one, other = both(features, weights)
    alpha = other.solve(y)
    assert np.allclose(features.T @ alpha, one.solve(y), atol=1e-10)
    fitted = other.fitted(alpha)
    assert np.allclose(fitted, one.fitted(one.solve(y)), atol=1e-10)
    assert np.allclose(other.left_out(y, fitted).mean, one.left_out(y, fitted).mean, atol=1e-8)
    new = np.random.default_rng(6).normal(size=(7, 30))
    found = other.variance(new @ features.T, (new**2).sum(axis=1))
    assert np.allclose(found, one.variance(new), atol=1e-9)


def test_what_is_left_out_is_what_a_fit_without_the_row_says(problem):
    features, weights, y = problem
    gram = features @ features.T
    posterior = CovariancePosterior.of(gram, weights)
    found = posterior.left_out(y, posterior.fitted(posterior.solve(y)))
    for row in (0, 7, 19):
        rest = np.arange(20) != row
        other = CovariancePosterior.of(gram[np.ix_(rest, rest)], weights[rest])
        cross = gram[[row]][:, rest]
        assert np.allclose(found.mean[row], cross @ other.solve(y[rest]), atol=1e-9)
        assert np.isclose(found.variance[row], other.variance(cross, gram[row, [row]])[0])


@pytest.mark.parametrize("missing", [0.1, 0.4, 0.8])
def test_entries_that_are_missing_have_no_say(problem, missing):
    features, weights, y = problem
    gram = features @ features.T
    known = np.random.default_rng(6).random(y.shape) > missing
    wild = np.where(known, y, 1e6)
    alpha = CovariancePosterior.of(gram, weights).solve(wild, known)
    assert np.array_equal(alpha[~known], np.zeros((~known).sum()))
    for channel in range(3):
        rows = known[:, channel]
        own = CovariancePosterior.of(gram[np.ix_(rows, rows)], weights[rows])
        assert np.allclose(alpha[rows, channel], own.solve(y[rows, channel][:, None])[:, 0])


def test_a_row_of_no_weight_is_predicted_and_says_nothing(problem):
    features, weights, y = problem
    weights = weights.copy()
    weights[4] = 0.0
    posterior = CovariancePosterior.of(features @ features.T, weights)
    wild = y.copy()
    wild[4] += 1e3
    one, other = (posterior.fitted(posterior.solve(value)) for value in (y, wild))
    assert np.abs(one - other).max() < 0.02
    assert np.allclose(posterior.left_out(y, one).mean[4], one[4], atol=1e-3)


def test_a_column_of_which_nothing_is_known_has_no_say(problem):
    features, weights, y = problem
    known = np.ones(y.shape, dtype=bool)
    known[:, 1] = False
    posterior = CovariancePosterior.of(features @ features.T, weights)
    alpha = posterior.solve(y, known)
    assert np.array_equal(alpha[:, 1], np.zeros(20))
    assert np.array_equal(alpha[:, [0, 2]], posterior.solve(y[:, [0, 2]]))
