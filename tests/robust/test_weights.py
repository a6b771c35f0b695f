"""The contract of weight functions, and the scale they are measured by."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brdfit.robust import cauchy, mad, relative_exponential

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


def test_mad_estimates_the_standard_deviation_of_a_normal_sample(rng):
    assert mad(rng.normal(5.0, 2.0, 50_000)) == pytest.approx(2.0, rel=0.03)
    assert mad(rng.normal(0.0, 2.0, 50_000), 0.0) == pytest.approx(2.0, rel=0.03)


@given(st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=40), st.floats(-1e3, 1e3))
def test_mad_follows_scale_and_ignores_shift(values, shift):
    sample = np.array(values)
    size = max(np.abs(sample).max(), abs(shift), 1.0)
    assert mad(sample + shift) == pytest.approx(mad(sample), abs=1e-9 * size)
    assert mad(-3.0 * sample) == pytest.approx(3.0 * mad(sample), abs=1e-9 * size)


def test_mad_is_not_moved_far_by_wild_values_and_leaves_out_what_is_missing(rng):
    sample = rng.normal(size=1000)
    wild = np.concatenate([sample, np.full(300, 1e9), np.full(50, np.nan)])
    assert mad(wild) < 2.0 * mad(sample)
    assert mad(np.concatenate([sample, [np.nan]])) == mad(sample)


def test_mad_of_nothing_is_zero():
    assert mad(np.array([])) == 0.0
    assert mad(np.array([np.nan])) == 0.0
