"""Combinations of a population: plain, and kept from being dragged away by outliers."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.reconstruct import GlobalBasis
from brdfit.reconstruct.combination import (
    RobustStart,
    combine,
    encode_members,
    equal_columns,
    fit_combination,
    nearest_member,
)
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.targets import Targets
from brdfit.transform import ERROR_METRICS, error_metric

METRICS = sorted(ERROR_METRICS)
ROLES = np.arange(3)


@pytest.fixture
def problem(toy, measure):
    """Return (rows, targets, samples) of m4 with m4 left out."""
    samples = measure(n=200)
    rows = MemberRows.at(toy.without(["m4"]), samples.wi, samples.wo)
    return rows, Targets.of(samples), samples


@pytest.mark.parametrize("name", METRICS)
def test_a_combination_is_the_encoded_design_times_its_coefficients(problem, name):
    rows, targets, _ = problem
    metric = error_metric(name)
    found = fit_combination(rows, targets, ROLES, metric, None)
    log_value = found.log_value(rows)
    for channel in ROLES:
        encoded = encode_members(rows.logs[channel], metric) @ found.coefficients[channel]
        assert np.allclose(log_value[:, channel], metric.decode(encoded), atol=1e-4)
    members = found.coefficients[:, : rows.members]
    assert (members >= 0.0).all()
    one = combine(rows.logs[0], metric, found.coefficients[:1])
    assert np.allclose(one[:, 0], log_value[:, 0])


@pytest.mark.parametrize("name", METRICS)
def test_the_plain_fit_is_the_best_in_the_domain_of_its_metric(problem, name):
    rows, targets, _ = problem
    fits = {
        other: fit_combination(rows, targets, ROLES, error_metric(other), None).log_value(rows)
        for other in METRICS
    }
    metric = error_metric(name)
    truth = metric.encode(targets.log_value)
    error = {other: ((metric.encode(log) - truth) ** 2).sum() for other, log in fits.items()}
    assert min(error, key=error.__getitem__) == name


@pytest.mark.parametrize("name", METRICS)
def test_the_robust_start_keeps_close_to_what_it_is_without_outliers(problem, name):
    rows, targets, samples = problem
    rng = np.random.default_rng(5)
    value = samples.value.copy()
    bad = rng.random(len(samples)) < 0.4
    value[bad] *= np.exp(rng.uniform(0.0, np.log(10.0), bad.sum()))[:, None]
    spoiled = Targets.of(samples.with_value(value))
    metric = error_metric(name)

    def moved(robust):
        clean, dirty = (
            fit_combination(rows, given, ROLES, metric, robust).log_value(rows)
            for given in (targets, spoiled)
        )
        return np.abs(clean - dirty).mean()

    assert moved(RobustStart()) < 0.8 * moved(None)


def test_a_robust_start_on_some_of_the_samples_looks_at_usable_ones(problem):
    rows, targets, _ = problem
    usable = targets.usable.copy()
    usable[:150] = False
    log_value = np.where(usable, targets.log_value, np.nan)
    holed = Targets(log_value, usable, targets.censored)
    log = error_metric("log")
    some = fit_combination(rows, holed, ROLES, log, RobustStart(rows=50))
    kept = fit_combination(
        rows.take(slice(150, None)), targets.take(np.arange(200) >= 150), ROLES, log, RobustStart()
    )
    assert np.array_equal(some.coefficients, kept.coefficients)


@pytest.mark.parametrize("name", METRICS)
def test_the_nearest_member_of_a_scaled_member_is_that_member(toy, measure, name):
    samples = measure("m6", noise=0.0)
    rows = MemberRows.at(toy, samples.wi, samples.wo)
    targets = Targets.of(samples.with_value(5.0 * samples.value))
    metric = error_metric(name)
    found = nearest_member(rows, targets, ROLES, metric)
    members = found.coefficients[:, : len(toy)]
    assert [np.flatnonzero(row).tolist() for row in members] == [[6]] * 3
    assert np.allclose(found.log_value(rows), targets.log_value, atol=1e-4)


def test_channels_of_equal_weights_are_solved_together():
    weights = np.array([[1.0, 0.5, 1.0, 0.0], [2.0, 2.0, 2.0, 0.0]])
    groups = [group.tolist() for group in equal_columns(weights, np.arange(4))]
    assert groups == [[0, 2], [1], [3]]
    assert [group.tolist() for group in equal_columns(weights, np.array([3, 1]))] == [[3], [1]]


@pytest.mark.parametrize("name", METRICS)
def test_the_global_basis_recovers_a_member_and_leaves_censored_values_out(
    toy, measure, random_directions, name
):
    samples = measure("m4", noise=0.0)
    somewhere = random_directions(200)
    method = GlobalBasis(population=toy, error_metric=name)
    truth = toy.subset(["m4"]).evaluate(*somewhere)[:, 0]
    found = method.fit(samples).evaluate(*somewhere)
    assert np.abs(np.log(found / truth)).mean() < 0.01
    value = samples.value.copy()
    value[::10] = 0.0
    zeros = method.fit(samples.with_value(value))
    gone = method.fit(samples.subset(np.flatnonzero(np.arange(150) % 10)))
    assert np.array_equal(zeros.evaluate(*somewhere), gone.evaluate(*somewhere))
