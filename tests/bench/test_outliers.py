"""Laws of the outlier models: how many, which, and that all channels go together."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.bench.outliers import DEFAULT_OUTLIERS, OUTLIER_MODELS, contaminate
from brdfit.errors import UsageError

N = 203
VALUES = np.exp(np.random.default_rng(0).normal(size=(N, 3)))
THETA_I = np.random.default_rng(1).uniform(0.0, 1.5, N)


def spoil(model: str, ratio: float, seed: int = 5):
    return contaminate(model, VALUES, ratio, np.random.default_rng(seed), THETA_I)


@pytest.mark.parametrize("model", OUTLIER_MODELS)
@pytest.mark.parametrize("ratio", [0.0, 0.004, 0.2, 0.8, 1.0])
def test_exactly_the_asked_share_is_marked(model, ratio):
    assert spoil(model, ratio).mask.sum() == round(ratio * N)


@pytest.mark.parametrize("model", OUTLIER_MODELS)
def test_only_marked_samples_change_and_all_their_channels_do(model):
    spoilt = spoil(model, 0.4)
    changed = spoilt.values != VALUES
    assert not changed[~spoilt.mask].any()
    assert changed[spoilt.mask].all()


@pytest.mark.parametrize("model", OUTLIER_MODELS)
def test_the_seed_decides_everything_and_the_input_stays(model):
    before = VALUES.copy()
    first, second = spoil(model, 0.3), spoil(model, 0.3)
    assert np.array_equal(first.values, second.values)
    assert np.array_equal(first.mask, second.mask)
    assert np.array_equal(VALUES, before)


@pytest.mark.parametrize("model", sorted({*OUTLIER_MODELS} - {"saturate"}))
def test_another_seed_gives_other_outliers(model):
    assert not np.array_equal(spoil(model, 0.3, 1).values, spoil(model, 0.3, 2).values)


@pytest.mark.parametrize("model", OUTLIER_MODELS)
def test_spoilt_values_stay_finite_and_not_negative(model):
    values = spoil(model, 0.9).values
    assert np.isfinite(values).all()
    assert (values >= 0.0).all()


@pytest.mark.parametrize("model", ["factor", "shadow", "saturate", "cluster"])
def test_one_factor_hits_all_channels_of_a_sample(model):
    ratio = spoil(model, 0.5).values / VALUES
    assert np.allclose(ratio, ratio[:, :1], rtol=1e-12)


def test_factors_are_log_uniform_between_a_tenth_and_ten():
    values = np.ones((20000, 1))
    spoilt = contaminate("factor", values, 1.0, np.random.default_rng(3))
    exponent = np.log10(spoilt.values[:, 0])
    assert exponent.min() >= -1.0
    assert exponent.max() <= 1.0
    assert np.allclose(np.quantile(exponent, [0.25, 0.5, 0.75]), [-0.5, 0.0, 0.5], atol=0.03)


def test_uniform_reaches_up_to_the_99th_percentile_of_each_channel():
    top = np.percentile(VALUES, 99.0, axis=0)
    share = spoil("uniform", 1.0).values / top
    assert np.allclose(share, share[:, :1])
    assert share.min() >= 0.0
    assert 0.95 < share.max() <= 1.0


def test_permuted_values_are_the_same_values_elsewhere():
    spoilt = spoil("permute", 0.4)
    before = np.sort(VALUES[spoilt.mask], axis=0)
    assert np.array_equal(np.sort(spoilt.values[spoilt.mask], axis=0), before)


def test_a_single_permuted_sample_takes_the_value_of_another():
    spoilt = contaminate("permute", VALUES, 1.0 / N, np.random.default_rng(0))
    row = int(np.flatnonzero(spoilt.mask)[0])
    assert not np.array_equal(spoilt.values[row], VALUES[row])
    assert (spoilt.values[row] == VALUES).all(axis=1).any()


def test_shadows_are_nearly_black():
    spoilt = spoil("shadow", 0.5)
    assert (spoilt.values[spoilt.mask] <= 0.01001 * VALUES[spoilt.mask]).all()


def test_saturation_leaves_nothing_brighter_than_the_brightest_that_was_not_hit():
    spoilt = spoil("saturate", 0.2)
    brightness = spoilt.values.mean(axis=1)
    assert brightness[spoilt.mask].max() <= brightness[~spoilt.mask].max() * (1 + 1e-12)
    assert VALUES[spoilt.mask].mean(axis=1).min() > VALUES[~spoilt.mask].mean(axis=1).max()


def test_a_cluster_is_a_window_of_incidence_angles_with_one_factor():
    spoilt = spoil("cluster", 0.3)
    low, high = THETA_I[spoilt.mask].min(), THETA_I[spoilt.mask].max()
    inside = (low <= THETA_I) & (high >= THETA_I)
    assert np.array_equal(inside, spoilt.mask)
    factor = (spoilt.values / VALUES)[spoilt.mask]
    assert np.allclose(factor, factor[0, 0])
    assert abs(np.log(factor[0, 0])) >= np.log(2.0) - 1e-12


def test_a_cluster_without_incidence_angles_says_what_is_missing():
    with pytest.raises(UsageError, match="theta_i"):
        contaminate("cluster", VALUES, 0.2, np.random.default_rng(0))


def test_an_unknown_model_names_the_known_ones():
    with pytest.raises(UsageError, match="factor, uniform, permute"):
        contaminate("typo", VALUES, 0.2, np.random.default_rng(0))


@pytest.mark.parametrize("ratio", [-0.1, 1.1, float("nan")])
def test_a_ratio_that_is_no_share_is_refused(ratio):
    with pytest.raises(UsageError, match="between 0 and 1"):
        contaminate(DEFAULT_OUTLIERS, VALUES, ratio, np.random.default_rng(0))
