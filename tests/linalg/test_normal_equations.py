"""Least squares from normal equations: closed forms, SciPy, conditions of optimality."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from brdfit.errors import FitError
from brdfit.linalg import NormalEquations, nonnegative, ridge, ridge_with_intercept

SEEDS = st.integers(0, 10_000)
GRID = tuple(10.0**exponent for exponent in range(-6, 3))


def problem(seed, n=60, k=7, c=2):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(n, k)) + 0.5
    y = x @ rng.normal(size=(k, c)) + 0.1 * rng.normal(size=(n, c))
    return x, y, rng.uniform(0.1, 2.0, n)


def test_the_sums_are_those_of_their_definition():
    x, y, w = problem(0)
    equations = NormalEquations.of(x, y, w)
    assert np.allclose(equations.gram, x.T @ np.diag(w) @ x)
    assert np.allclose(equations.moment, x.T @ np.diag(w) @ y)
    assert np.allclose(equations.power, [y[:, c] @ np.diag(w) @ y[:, c] for c in range(2)])
    assert equations.total == pytest.approx(w.sum())
    one = equations.one(1)
    assert np.array_equal(one.moment, equations.moment[:, 1])
    assert one.power == equations.power[1]


def test_rows_in_single_precision_are_summed_into_double():
    x, y, w = problem(1)
    equations = NormalEquations.of(x.astype(np.float32), y, w)
    assert equations.gram.dtype == equations.moment.dtype == np.float64


# --- ridge ---------------------------------------------------------------------------------


@given(SEEDS, st.sampled_from(GRID))
def test_ridge_of_one_damping_is_the_closed_form(seed, damping):
    x, y, w = problem(seed)
    fit = ridge(NormalEquations.of(x, y, w), (damping,))
    gram = (x.T * w) @ x + damping * w.sum() * np.eye(x.shape[1])
    assert np.allclose(fit.coefficients, np.linalg.solve(gram, (x.T * w) @ y), rtol=1e-6)
    assert fit.damping == damping
    # the trace of the matrix that takes y to its prediction
    freedom = np.trace(np.linalg.solve(gram, (x.T * w) @ x))
    assert fit.freedom == pytest.approx(freedom, rel=1e-6)


def test_one_right_hand_side_gives_a_vector():
    x, y, w = problem(2)
    both = ridge(NormalEquations.of(x, y, w), (1e-3,)).coefficients
    alone = ridge(NormalEquations.of(x, y[:, 0], w), (1e-3,)).coefficients
    assert alone.shape == (7,)
    assert np.allclose(alone, both[:, 0])


@pytest.mark.parametrize("seed", range(5))
def test_cross_validation_damps_pure_noise_and_leaves_clean_data_alone(seed):
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(80, 40))
    w = np.ones(80)
    noise = ridge(NormalEquations.of(x, rng.normal(size=(80, 1)), w), GRID)
    clean = ridge(NormalEquations.of(x, x @ rng.normal(size=(40, 1)), w), GRID)
    assert noise.damping >= 1.0
    assert noise.freedom < 25
    assert clean.damping == GRID[0]
    assert clean.freedom == pytest.approx(40, abs=0.1)


def test_cross_validation_takes_the_smallest_score_of_its_formula():
    x, y, w = problem(3, n=25, k=20)
    equations = NormalEquations.of(x, y, w)
    scores = []
    for damping in GRID:
        fit = ridge(equations, (damping,))
        rss = (w[:, None] * (y - x @ fit.coefficients) ** 2).sum() / w.sum()
        scores.append(rss / (1.0 - fit.freedom / w.sum()) ** 2)
    assert ridge(equations, GRID).damping == GRID[int(np.argmin(scores))]


def test_more_columns_than_rows_still_give_a_finite_fit():
    x, y, w = problem(4, n=10, k=30)
    fit = ridge(NormalEquations.of(x, y, w), GRID)
    assert np.isfinite(fit.coefficients).all()
    assert fit.freedom <= 10


@given(SEEDS)
def test_scaling_all_weights_changes_no_coefficient_of_a_given_damping(seed):
    x, y, w = problem(seed)
    one = ridge(NormalEquations.of(x, y, w), (1e-2,)).coefficients
    ten = ridge(NormalEquations.of(x, y, 10.0 * w), (1e-2,)).coefficients
    assert np.allclose(one, ten)


# --- an undamped intercept -----------------------------------------------------------------


@given(SEEDS, st.floats(-100.0, 100.0))
def test_adding_a_constant_to_the_targets_only_moves_the_intercept(seed, constant):
    x, y, w = problem(seed)
    intercept, fit = ridge_with_intercept(x, y, w, (1.0,))
    moved, same = ridge_with_intercept(x, y + constant, w, (1.0,))
    assert np.allclose(moved - intercept, constant)
    assert np.allclose(same.coefficients, fit.coefficients)


@given(SEEDS, st.floats(-10.0, 10.0))
def test_adding_a_constant_to_the_columns_changes_no_prediction(seed, constant):
    x, y, w = problem(seed)
    predictions = []
    for design in (x, x + constant):
        intercept, fit = ridge_with_intercept(design, y, w, (1.0,))
        predictions.append(intercept + design @ fit.coefficients)
    assert np.allclose(*predictions)


def test_a_large_damping_leaves_the_weighted_mean():
    x, y, w = problem(5)
    intercept, fit = ridge_with_intercept(x, y, w, (1e9,))
    assert np.allclose(fit.coefficients, 0.0, atol=1e-8)
    assert np.allclose(intercept, w @ y / w.sum())


def test_rows_of_weight_zero_have_no_say():
    x, y, w = problem(6)
    w[:5] = 0.0
    wild = y.copy()
    wild[:5] = 1e6
    one, other = (ridge_with_intercept(x, values, w, GRID) for values in (y, wild))
    assert np.allclose(one[0], other[0])
    assert np.allclose(one[1].coefficients, other[1].coefficients)


# --- non-negative --------------------------------------------------------------------------


@given(SEEDS)
def test_nonnegative_is_what_scipy_finds_from_all_rows(seed):
    x, y, w = problem(seed)
    found = nonnegative(NormalEquations.of(x, y, w))
    root = np.sqrt(w)
    for c in range(y.shape[1]):
        expected, _ = nnls(x * root[:, None], y[:, c] * root)
        assert np.allclose(found[:, c], expected, atol=1e-5)


@given(SEEDS, st.integers(0, 3))
def test_nonnegative_meets_the_conditions_of_optimality(seed, free):
    x, y, w = problem(seed, c=1)
    equations = NormalEquations.of(x, y[:, 0], w)
    a = nonnegative(equations, free)
    gradient = equations.gram @ a - equations.moment
    scale = np.abs(equations.moment).max()
    bound = len(a) - free
    assert a.shape == (7,)
    assert (a[:bound] >= 0.0).all()
    assert (gradient[:bound] >= -1e-6 * scale).all()
    assert np.abs(gradient[:bound] * a[:bound]).max() < 1e-5 * scale
    assert np.abs(gradient[bound:]).max(initial=0.0) < 1e-5 * scale


def test_free_coefficients_may_be_negative_and_the_others_not():
    x, _, w = problem(7)
    truth = np.array([1.0, 0.0, 2.0, 0.0, 0.5, 0.0, -3.0])
    equations = NormalEquations.of(x, x @ truth, w)
    assert np.allclose(nonnegative(equations, free=1), truth, atol=1e-6)
    assert nonnegative(equations).min() >= 0.0


def test_columns_of_very_different_size_are_solved_alike():
    x, _, w = problem(8)
    scale = 10.0 ** np.linspace(-6, 6, 7)
    truth = np.array([1.0, 0.0, 2.0, 0.0, 0.5, 0.0, 3.0])
    found = nonnegative(NormalEquations.of(x * scale, x @ truth, w))
    assert np.allclose(found * scale, truth, atol=1e-5)


def test_equal_columns_and_a_column_of_zeros_do_no_harm():
    x, _, w = problem(9)
    x[:, 1] = x[:, 0]
    x[:, 2] = 0.0
    y = 2.0 * x[:, 0] + x[:, 4]
    found = nonnegative(NormalEquations.of(x, y, w))
    assert np.isfinite(found).all()
    assert np.allclose(x @ found, y, atol=1e-5)


def test_a_design_with_values_that_are_not_finite_is_refused_in_words():
    x, y, w = problem(10)
    x[3, 3] = np.nan
    with pytest.raises(FitError, match="not finite"):
        nonnegative(NormalEquations.of(x, y, w))


def test_equations_of_parts_add_up_to_those_of_the_whole(rng):
    x, y, weights = rng.normal(size=(30, 4)), rng.normal(size=(30, 2)), rng.random(30)
    whole = NormalEquations.of(x, y, weights)
    parts = [NormalEquations.of(x[s], y[s], weights[s]) for s in (slice(0, 11), slice(11, 30))]
    total = parts[0] + parts[1]
    assert np.allclose(total.gram, whole.gram)
    assert np.allclose(total.moment, whole.moment)
    assert np.isclose(total.total, whole.total)
    assert np.allclose(total.power, whole.power)
