"""The line between scatter and wrong measurements, and what it says of a fit."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.reconstruct import Outcome
from brdfit.reconstruct.outliers import FEWEST, SMALLEST, find_outliers


def noisy(rng, n=400, channels=3, scale=0.02):
    return scale * rng.normal(size=(n, 1)) * np.ones(channels)


ALL = np.ones((400, 3), dtype=bool)


@pytest.mark.parametrize("share", [0.05, 0.4, 0.6])
def test_wild_residuals_are_named_even_where_they_are_the_majority(rng, share):
    residuals = noisy(rng)
    wild = rng.random(400) < share
    residuals[wild] += 1.5
    found = find_outliers(residuals, ALL, per_channel=False)
    assert np.array_equal(found.rows, wild)


@pytest.mark.parametrize("scale", [1e-9, 0.02, 0.05])
def test_nothing_within_thirty_percent_is_named(rng, scale):
    residuals = np.clip(noisy(rng, scale=scale), -0.26, 0.26)
    assert not find_outliers(residuals, ALL, per_channel=False).rows.any()
    assert np.isclose(SMALLEST, np.log(1.3))


def test_a_noisy_instrument_is_not_all_outliers(rng):
    found = find_outliers(noisy(rng, scale=0.5), ALL, per_channel=False)
    assert found.rows.mean() < 0.02
    assert "above" in found.rule


def test_what_is_unusable_or_unknown_is_never_named(rng):
    residuals = noisy(rng)
    residuals[:10] = 3.0
    residuals[:5] = np.nan
    usable = ALL.copy()
    usable[5:10] = False
    found = find_outliers(residuals, usable, per_channel=False)
    assert not found.rows[:10].any()
    assert found.usable == 395


def test_one_channel_counts_by_its_share_or_on_its_own(rng):
    residuals = noisy(rng, channels=3)
    residuals[0, 1] = 0.6  # a fifth off on average: within 30 %
    assert not find_outliers(residuals, ALL, per_channel=False).rows[0]
    assert find_outliers(residuals, ALL, per_channel=True).rows[0]
    residuals[0, 1] = 3.0
    assert find_outliers(residuals, ALL, per_channel=False).rows[0]


def test_each_channel_has_its_own_scale_and_the_rule_states_the_span(rng):
    residuals = rng.normal(size=(400, 3)) * [0.01, 0.2, 0.5]
    residuals[0] = [0.5, 0.5, 0.5]
    found = find_outliers(residuals, ALL, per_channel=True)
    assert found.rows[0]
    assert found.rows.mean() < 0.02
    assert " to " in found.rule


@pytest.mark.parametrize("per_channel", [False, True])
def test_a_fit_is_judged_by_how_many_samples_disagree(rng, per_channel):
    ending = Outcome.CONVERGED
    residuals = noisy(rng)
    assert find_outliers(residuals, ALL, per_channel).outcome(ending) is ending
    residuals[:240] += 2.0
    found = find_outliers(residuals, ALL, per_channel)
    assert found.outcome(ending) is Outcome.MOSTLY_OUTLIERS
    # no scale is robust against this: none is named, and still the fit is no good
    scattered = noisy(rng, scale=3.0)
    found = find_outliers(scattered, ALL, per_channel)
    assert found.rows.mean() < 0.02
    assert found.outcome(ending) is Outcome.MOSTLY_OUTLIERS
    few = find_outliers(noisy(rng, n=FEWEST - 1), ALL[: FEWEST - 1], per_channel)
    assert few.outcome(ending) is Outcome.TOO_FEW_SAMPLES


def test_every_outcome_has_its_advice_and_calls_for_attention_or_not():
    for outcome in Outcome:
        assert outcome.advice.endswith(".")
    assert {outcome for outcome in Outcome if outcome.ok} == {
        Outcome.CONVERGED,
        Outcome.NO_IMPROVEMENT,
        Outcome.DIRECT,
    }
