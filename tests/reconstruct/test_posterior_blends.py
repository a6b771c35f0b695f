"""Blends: sums of two columns, that never speak for a material that is left out."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.reconstruct.posterior.blends import Blends
from brdfit.reconstruct.posterior.principal import principal_basis


@pytest.fixture
def logs():
    return np.random.default_rng(3).normal(size=(400, 12)).astype(np.float32)


def test_a_blend_is_the_sum_of_what_its_parents_reflect(logs):
    blends = Blends.of(logs)
    joined = blends.joined(logs)
    assert np.array_equal(joined[:, :12], logs)
    sums = np.exp(logs[:, blends.pairs] + blends.shifts).sum(axis=1)
    assert np.allclose(np.exp(joined[:, 12:]), sums, rtol=1e-5)


def test_the_brightness_of_a_column_has_no_say(logs):
    blends = Blends.of(logs)
    lifted = logs + np.arange(12, dtype=np.float32)
    again = Blends.of(lifted)
    assert np.array_equal(again.pairs, blends.pairs)
    assert np.allclose(again.joined(lifted)[:, 12:], blends.joined(logs)[:, 12:], atol=1e-5)


def test_a_blend_counts_as_its_parents_do_and_not_at_all_without_one(logs):
    blends = Blends.of(logs)
    even = blends.weights(np.full(12, 0.25))
    assert np.allclose(even, 0.25)
    weights = np.full(12, 0.25)
    weights[4] = 0.0
    of_blends = blends.weights(weights)[12:]
    assert np.array_equal(of_blends == 0.0, (blends.pairs == 4).any(axis=0))


@pytest.mark.parametrize(("columns", "expected"), [(1, 0), (12, 36), (300, 900), (1150, 50)])
def test_a_population_of_many_columns_needs_few(columns, expected):
    logs = np.random.default_rng(5).normal(size=(9, columns)).astype(np.float32)
    assert Blends.of(logs).pairs.shape == (2, expected)


def test_a_member_left_out_has_no_column_and_no_blend(toy):
    basis = principal_basis(toy)
    weights = basis.column_weights(toy.without(["m4"]))
    members, channels = len(toy), len(toy.channels)
    own = np.arange(members * channels) % members == list(toy.members).index("m4")
    assert np.array_equal(weights[: own.size] == 0.0, own)
    touched = own[basis.blends.pairs].any(axis=0)
    assert np.array_equal(weights[own.size :] == 0.0, touched)
    assert 0 < touched.sum() < touched.size
