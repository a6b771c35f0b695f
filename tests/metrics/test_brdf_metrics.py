"""Laws of the metrics in BRDF space, and their formulas written a second time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.metrics import (
    METRICS,
    cosine_rms,
    cube_root_cosine,
    cube_root_rms,
    log_rms,
    mean_abs_log,
)

VALUE_METRICS = [metric.function for metric in METRICS.values() if metric.compares == "values"]

every_metric = pytest.mark.parametrize("metric", VALUE_METRICS, ids=lambda m: m.__name__)


@pytest.fixture
def case(rng):
    r, t = np.exp(rng.normal(0.0, 1.0, (2, 50, 3)))
    cos_i, cos_o, weights = rng.uniform(0.1, 1.0, (3, 50))
    return r, t, cos_i, cos_o, weights


@every_metric
def test_a_brdf_has_no_distance_from_itself(metric, case):
    r, _, *rest = case
    assert metric(r, r, *rest) == (0.0, 150, 0)


@every_metric
def test_reference_and_test_may_be_exchanged(metric, case):
    r, t, *rest = case
    assert metric(r, t, *rest).value == pytest.approx(metric(t, r, *rest).value)


@every_metric
def test_weights_of_two_count_like_entries_that_occur_twice(metric, case):
    r, t, cos_i, cos_o, _ = case
    twice = np.where(np.arange(50) < 10, 2.0, 1.0)
    again = np.concatenate([np.arange(50), np.arange(10)])
    assert metric(r, t, cos_i, cos_o, twice).value == pytest.approx(
        metric(r[again], t[again], cos_i[again], cos_o[again]).value
    )


@every_metric
def test_missing_and_negative_entries_are_skipped_and_counted(metric, case):
    r, t, cos_i, cos_o, weights = case
    keep = metric(r[3:], t[3:], cos_i[3:], cos_o[3:], weights[3:])
    r, t = r.copy(), t.copy()
    r[0], r[1], t[2] = np.nan, -1.0, np.inf
    found = metric(r, t, cos_i, cos_o, weights)
    assert found.value == pytest.approx(keep.value)
    assert (found.used, found.skipped) == (141, 9)


@every_metric
def test_nothing_to_compare_is_nan_and_says_that_all_was_skipped(metric):
    score = metric(np.full(4, np.nan), np.ones(4), np.ones(4), np.ones(4))
    assert math.isnan(score.value)
    assert (score.used, score.skipped) == (0, 4)


def test_the_formulas_are_those_of_the_papers():
    r, t, cos_i, cos_o = [1.0, 2.0], [1.5, 1.0], [0.5, 0.8], [0.9, 0.0005]
    args = (np.array(r), np.array(t), np.array(cos_i), np.array(cos_o))
    logs = [math.log(1.5), math.log(0.5)]
    weighted = [0.5 * 0.5, -1.0 * 0.8]
    both = [0.5 * 0.45, -1.0 * 0.001]
    expected = {
        log_rms: math.sqrt((logs[0] ** 2 + logs[1] ** 2) / 2),
        mean_abs_log: (abs(logs[0]) + abs(logs[1])) / 2,
        cosine_rms: math.sqrt((weighted[0] ** 2 + weighted[1] ** 2) / 2),
        cube_root_rms: math.sqrt(sum(abs(x) ** (2 / 3) for x in weighted) / 2),
        cube_root_cosine: sum(abs(x) ** (2 / 3) for x in both) / 2,
    }
    assert set(expected) == set(VALUE_METRICS)
    for metric, value in expected.items():
        assert metric(*args).value == pytest.approx(value)


def test_zeros_have_no_logarithm_but_a_difference():
    args = (np.array([0.0, 1.0]), np.ones(2), np.ones(2), np.ones(2))
    assert log_rms(*args).skipped == 1
    assert cosine_rms(*args).skipped == 0


def test_the_logarithmic_metrics_do_not_care_about_the_scale(case):
    r, t, *rest = case
    for metric in (log_rms, mean_abs_log):
        assert metric(9.0 * r, 9.0 * t, *rest).value == pytest.approx(metric(r, t, *rest).value)


def test_different_channels_are_refused_with_both_counts():
    with pytest.raises(UsageError, match="found 1 channels but the reference has 3"):
        log_rms(np.ones((4, 3)), np.ones(4), np.ones(4), np.ones(4))


def test_cosines_must_pair_up_with_the_directions():
    with pytest.raises(UsageError, match=r"cos_theta_o: found shape \(3,\) but there are 4"):
        log_rms(np.ones(4), np.ones(4), np.ones(4), np.ones(3))
