"""The published method: outliers have no say, and iterating never makes it worse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from brdfit.errors import SampleError
from brdfit.reconstruct import CorrectionFunctions, GlobalBasis, Outcome, corrections
from brdfit.samples import Samples


@pytest.fixture
def method(toy):
    """Return the method, leaning on all toy materials but m4."""
    return CorrectionFunctions(population=toy.without(["m4"]))


def spoil(samples, share, seed=3):
    """Multiply a share of the samples by factors between 1/10 and 10; return (samples, which)."""
    rng = np.random.default_rng(seed)
    bad = rng.random(len(samples)) < share
    factor = np.exp(rng.uniform(-np.log(10.0), np.log(10.0), len(samples)))
    value = np.where(bad[:, None], factor[:, None], 1.0) * samples.value
    return samples.with_value(value), bad


def distance(result, toy, member, somewhere):
    """Return the mean |ln result - ln member|."""
    truth = toy.subset([member]).evaluate(*somewhere)[:, 0]
    return np.abs(np.log(result.evaluate(*somewhere)) - np.log(truth)).mean()


@pytest.fixture
def somewhere(random_directions):
    return random_directions(300)


# --- outliers ------------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [30.0, 1 / 30.0, 1e6])
def test_one_wild_sample_moves_nothing_and_is_named(method, measure, somewhere, factor):
    samples = measure()
    value = samples.value.copy()
    value[17] *= factor
    result = method.fit(samples.with_value(value))
    without = method.fit(samples.subset(np.arange(len(samples)) != 17))
    moved = np.log(result.evaluate(*somewhere)) - np.log(without.evaluate(*somewhere))
    assert np.abs(moved).max() < 0.03
    assert np.flatnonzero(result.outliers).tolist() == [17]
    assert result.record()["outliers"]["rows"] == [18]  # counted from one
    assert result.weights[17] < 0.01
    assert "robust standard deviations" in result.outlier_rule


def test_two_of_five_samples_wrong_hardly_matter_where_the_global_basis_is_lost(
    method, toy, measure, somewhere
):
    spoiled, _ = spoil(measure(n=400), 0.4)
    ours = distance(method.fit(spoiled), toy, "m4", somewhere)
    clean = distance(method.fit(measure(n=400)), toy, "m4", somewhere)
    rival = GlobalBasis(population=method.population)
    harm = distance(rival.fit(spoiled), toy, "m4", somewhere)
    harm -= distance(rival.fit(measure(n=400)), toy, "m4", somewhere)
    assert ours - clean < harm / 3.0


@pytest.mark.parametrize("metric", ["linear", "root"])
def test_outliers_do_not_drag_the_start_away_under_any_metric(toy, measure, somewhere, metric):
    others = toy.without(["m4"])
    spoiled, _ = spoil(measure(n=400), 0.4)
    robust = CorrectionFunctions(population=others, error_metric=metric)
    plain = CorrectionFunctions(population=others, error_metric=metric, robust_start=False)
    clean = distance(robust.fit(measure(n=400)), toy, "m4", somewhere)
    harm = distance(robust.fit(spoiled), toy, "m4", somewhere) - clean
    start = distance(replace(plain, iterations=0).fit(spoiled), toy, "m4", somewhere)
    assert harm < (start - clean) / 3.0


def test_many_samples_are_iterated_on_in_part_and_judged_all(
    method, toy, measure, somewhere, monkeypatch
):
    spoiled, bad = spoil(measure(n=600), 0.4)
    whole = method.fit(spoiled)
    seen = []
    original = corrections.ridge_with_intercept

    def spy(x, *arguments):
        seen.append(len(x))
        return original(x, *arguments)

    monkeypatch.setattr(corrections, "_ENOUGH", 200)
    monkeypatch.setattr(corrections, "ridge_with_intercept", spy)
    part = method.fit(spoiled)
    assert min(seen) <= 200
    assert max(seen[-2:]) > 200
    first = [one["iteration"] for one in part.history]
    assert first == list(range(len(first)))
    assert part.iterations <= method.iterations
    near = distance(whole, toy, "m4", somewhere)
    assert distance(part, toy, "m4", somewhere) < 1.2 * near + 0.01
    assert np.median(part.weights[bad]) < np.median(part.weights[~bad])
    # the estimate that is reported is the one that the corrections make
    again = np.log(spoiled.value) - np.log(part.evaluate(spoiled.wi, spoiled.wo))
    assert np.allclose(again, part.residuals, atol=1e-3)


@pytest.mark.parametrize("share", [0.2, 0.4, 0.6])
def test_wrong_samples_weigh_less_and_are_named(method, measure, share):
    spoiled, bad = spoil(measure(n=400), share)
    result = method.fit(spoiled)
    wild = bad & (np.abs(result.residuals).mean(axis=1) > np.log(2.0))
    assert np.median(result.weights[bad]) < np.median(result.weights[~bad])
    assert result.weights[wild].max() < np.median(result.weights[~bad])
    assert result.outliers[wild].mean() > 0.9
    assert result.outliers[~bad].mean() < 0.05


def test_a_fit_that_most_samples_disagree_with_says_so(method, measure):
    spoiled, _ = spoil(measure(n=300), 0.8)
    result = method.fit(spoiled)
    assert result.outcome is Outcome.MOSTLY_OUTLIERS
    assert not result.outcome.ok
    assert "convention" in result.outcome.advice


def test_samples_of_another_instrument_scale_are_no_outliers(method, measure):
    result = method.fit(measure().with_value(20.0 * measure().value))
    assert not result.outliers.any()


# --- exactness and iteration ---------------------------------------------------------------


@pytest.mark.parametrize("metric", ["linear", "root", "log"])
def test_a_member_of_the_population_is_recovered_from_its_own_samples(
    toy, measure, somewhere, metric
):
    result = CorrectionFunctions(population=toy, error_metric=metric).fit(measure(noise=0.0))
    assert result.outcome.ok
    assert distance(result, toy, "m4", somewhere) < 0.005


def test_corrections_bring_the_estimate_nearer_to_the_samples(method, toy, measure, somewhere):
    samples = measure(n=400, noise=0.0)
    corrected = method.fit(samples)
    plain = CorrectionFunctions(population=method.population, iterations=0).fit(samples)
    assert corrected.iterations > 0
    assert plain.iterations == 0
    assert np.abs(corrected.residuals).mean() < np.abs(plain.residuals).mean()
    assert np.allclose(corrected.initial_residuals, plain.residuals)
    assert distance(corrected, toy, "m4", somewhere) < distance(plain, toy, "m4", somewhere)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7])
def test_more_iterations_never_make_the_kept_result_worse(method, measure, share):
    spoiled, _ = spoil(measure(), share)
    losses = []
    for iterations in (0, 1, 2, 4, 8, 16):
        chosen = CorrectionFunctions(population=method.population, iterations=iterations)
        result = chosen.fit(spoiled)
        loss = min(record["loss"] for record in result.history)
        kept = result.history[result.iterations]["loss"]
        assert kept == loss
        assert result.iterations <= iterations
        # the loss is the mean of 1 - w
        assert kept == pytest.approx(1.0 - result.channel_weights.mean(), abs=1e-9)
        losses.append(kept)
    assert losses == sorted(losses, reverse=True)


def test_the_kept_iterate_is_the_one_that_is_evaluated(method, measure):
    spoiled, _ = spoil(measure(), 0.3)
    result = method.fit(spoiled)
    at_samples = result.evaluate(spoiled.wi, spoiled.wo)
    assert np.allclose(np.log(spoiled.value / at_samples), result.residuals, atol=1e-4)


def test_a_tolerance_that_is_met_ends_as_converged(method, measure):
    loose = CorrectionFunctions(population=method.population, tolerance=10.0).fit(measure())
    assert loose.outcome is Outcome.CONVERGED
    assert len(loose.history) == 2
    tight = CorrectionFunctions(population=method.population, tolerance=1e-12, iterations=1)
    assert tight.fit(measure()).outcome is Outcome.ITERATION_LIMIT


def test_a_given_damping_is_used_and_a_huge_one_makes_corrections_constant(method, measure):
    samples = measure()
    stiff = CorrectionFunctions(population=method.population, damping=1e9).fit(samples)
    for correction in stiff.model.corrections:
        assert np.abs(correction.coefficients).max() < 1e-6


def test_no_correction_exceeds_its_limit(method, measure, somewhere):
    samples = measure()
    held = CorrectionFunctions(population=method.population, sigma_limit=1.01).fit(samples)
    plain = CorrectionFunctions(population=method.population, iterations=0).fit(samples)
    ratio = np.log(held.evaluate(*somewhere) / plain.evaluate(*somewhere))
    assert np.abs(ratio).max() <= max(held.iterations, 1) * np.log(1.01) + 1e-5


def test_softening_lets_samples_speak_while_the_estimate_is_far_off(toy, measure):
    samples = measure("m0", n=300, noise=0.0)
    far = toy.subset(["m7", "m8", "m9"])
    off = {
        softening: CorrectionFunctions(population=far, gamma=500.0, softening=softening)
        .fit(samples)
        .record()["residuals"]["after"]["mean_abs"]
        for softening in (0.7, 1e9)
    }
    assert off[0.7] < 0.9 * off[1e9]


def test_of_a_handful_of_samples_only_the_scale_of_a_member_is_taken(method, measure, somewhere):
    values = method.fit(measure(n=7)).evaluate(*somewhere)
    members = method.population.evaluate(*somewhere)
    for channel in range(3):
        ratio = np.log(values[:, [channel]] / members[:, :, channel])
        assert np.ptp(ratio, axis=0).min() < 1e-4


# --- censored values -----------------------------------------------------------------------


def with_zeros(samples, zero_at):
    value = samples.value.copy()
    value[zero_at] = 0.0
    return samples.with_value(value)


@pytest.mark.parametrize("share", [0.0, 0.4])
def test_zeros_where_the_estimate_is_under_the_floor_change_nothing(toy, measure, somewhere, share):
    # Bright samples, some wrong, and zeros at directions far darker than any of them.
    samples = measure("m4", n=800)
    brightness = samples.value.min(axis=1)
    bright = np.flatnonzero(brightness > np.quantile(brightness, 0.8))
    floor = samples.subset(bright).noise_floor
    dark = np.flatnonzero((samples.value < 0.6 * floor).all(axis=1))
    assert dark.size > bright.size
    some = samples.subset(np.concatenate([bright, dark]))
    spoiled, _ = spoil(some.subset(np.arange(bright.size)), share)
    value = np.zeros(some.value.shape)
    spoiled = spoiled.with_value(np.maximum(spoiled.value, some.value[: bright.size]))
    value[: bright.size] = spoiled.value
    # a gamma too high for the noise, so that softening is at work; and enough damping that the
    # rounding of sums in another order stays what it is
    method = CorrectionFunctions(population=toy.without(["m3"]), gamma=80.0, damping=1.0)
    one, other = method.fit(spoiled), method.fit(some.with_value(value))
    assert one.iterations > 0
    assert other.iterations == one.iterations
    assert np.allclose(one.evaluate(*somewhere), other.evaluate(*somewhere), rtol=1e-5)
    assert (other.residuals[bright.size :] == 0.0).all()
    assert not other.outliers[bright.size :].any()


def test_zeros_where_the_estimate_is_high_lower_it(method, measure):
    # Half of the samples near grazing read zero: what the others say there comes down.
    samples = measure(n=300)
    theta_d = samples.half_diff[1]
    zero = np.flatnonzero(theta_d > np.quantile(theta_d, 0.7))
    left_out = method.fit(samples.subset(np.setdiff1d(np.arange(300), zero)))
    counted = method.fit(with_zeros(samples, zero))
    assert (counted.residuals[zero] <= 0.0).all()
    before = left_out.evaluate(samples.wi[zero], samples.wo[zero])
    after = counted.evaluate(samples.wi[zero], samples.wo[zero])
    assert np.median(after) < np.median(before)


def test_zeros_alone_say_nothing_of_a_channel(method, measure):
    samples = measure()
    value = samples.value.copy()
    value[:, 1] = 0.0
    with pytest.raises(SampleError, match="channel G has no usable positive value"):
        method.fit(samples.with_value(value))


# --- one verdict on a sample, or one on each channel ---------------------------------------


@pytest.fixture
def green_is_wrong(measure):
    """Return samples of which the first 30 are wrong in green only."""
    samples = measure(n=300)
    value = samples.value.copy()
    value[:30, 1] *= 8.0
    return samples.with_value(value)


def test_channels_share_one_verdict(method, green_is_wrong):
    weights = method.fit(green_is_wrong).channel_weights
    assert np.array_equal(weights[:, 0], weights[:, 1])
    assert np.array_equal(weights[:, 0], weights[:, 2])
    assert weights[:30].max() < np.median(weights[30:])


def test_verdicts_on_channels_differ_where_one_channel_is_wrong(method, green_is_wrong):
    chosen = CorrectionFunctions(population=method.population, per_channel=True)
    result = chosen.fit(green_is_wrong)
    red, green, blue = result.channel_weights[:30].T
    assert green.max() < 0.1
    assert np.median(red) > 0.5
    assert np.median(blue) > 0.5
    assert result.outliers[:30].all()
    assert result.outliers[30:].mean() < 0.05


# --- small populations ---------------------------------------------------------------------


@pytest.mark.parametrize("metric", ["linear", "root", "log"])
@pytest.mark.parametrize("names", [["m3"], ["m3", "m6"], ["m9"]])
def test_a_population_of_one_or_two_materials_still_gives_a_fit(
    toy, measure, somewhere, metric, names
):
    method = CorrectionFunctions(population=toy.subset(names), error_metric=metric)
    values = method.fit(measure("m3")).evaluate(*somewhere)
    assert np.isfinite(values).all()
    assert (values > 0.0).all()


def test_a_fit_asks_for_no_dense_columns(method, measure, tmp_path, monkeypatch):
    monkeypatch.setenv("BRDFIT_CACHE", str(tmp_path))
    method.fit(measure())
    assert {path.name for path in tmp_path.iterdir()} == {"arrays"}


def test_samples_that_share_their_directions_need_not_agree(method, measure):
    samples = measure(n=100)
    twice = Samples(
        wi=np.vstack([samples.wi, samples.wi]),
        wo=np.vstack([samples.wo, samples.wo]),
        value=np.vstack([samples.value, 20.0 * samples.value[:]]),
    )
    result = method.fit(twice.subset(np.r_[0:100, 100:120]))
    assert result.outliers[100:].all()
    assert not result.outliers[:100].any()
