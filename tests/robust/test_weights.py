"""The contract of weight functions, and the scale they are measured by."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brdfit.robust import cauchy, quartile_scale, relative_exponential

WEIGHTS = {
    "cauchy": lambda d: cauchy(d, 0.7),
    "relative exponential": lambda d: relative_exponential(d, 3.0),
}


@pytest.mark.parametrize("weight", WEIGHTS.values(), ids=WEIGHTS)
def test_a_weight_is_one_at_zero_and_falls_toward_zero(weight):
    deviation = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 200)])
    values = weight(deviation)
    assert values[0] == 1.0
    assert (np.diff(values) <= 0.0).all()
    assert ((values >= 0.0) & (values <= 1.0)).all()
    assert values[-1] < 1e-6


def test_the_weights_are_those_of_their_formulas():
    assert cauchy(np.array([-2.0, 0.5]), 0.5) == pytest.approx([1.0 / 17.0, 0.5])
    assert relative_exponential(np.array([0.25]), 8.0) == pytest.approx([np.exp(-2.0)])


def test_the_sign_of_a_residual_does_not_matter_to_cauchy():
    residual = np.linspace(-3, 3, 13)
    assert np.array_equal(cauchy(residual, 0.3), cauchy(-residual, 0.3))


def test_the_scale_is_the_standard_deviation_of_a_normal_sample(rng):
    assert quartile_scale(np.abs(rng.normal(0.0, 2.0, 50_000))) == pytest.approx(2.0, rel=0.03)


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=40), st.floats(0.0, 1e3))
def test_the_scale_follows_scale(values, factor):
    size = np.array(values)
    expected = factor * quartile_scale(size)
    assert quartile_scale(factor * size) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_majority_of_wild_values_does_not_carry_the_scale_away(rng):
    sample = np.abs(rng.normal(size=1000))
    wild = np.concatenate([sample, np.full(2000, 1e9)])  # two of three
    assert quartile_scale(wild) < 4.0


def test_the_scale_of_nothing_is_zero():
    assert quartile_scale(np.array([])) == 0.0
