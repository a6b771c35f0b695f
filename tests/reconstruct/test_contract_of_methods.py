"""What every method promises, whatever it does inside."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from brdfit.errors import SampleError, UsageError
from brdfit.geometry import directions_from_spherical
from brdfit.grid import Grid
from brdfit.reconstruct import METHODS, Outcome, Posterior, fit
from brdfit.samples import Flag, Samples

GRID = Grid(9, 8, 12)
# Settings that keep the tests quick.
QUICK = {"local": {"n_theta_h": 8, "n_theta_d": 6, "n_phi_d": 6}}

# A ridge of fixed strength about a mean of fixed brightness: a published property of the method,
# which test_pca_ridge.py pins down. All others follow scale, and repetition, exactly.
FIXED_RIDGE = {"pca_ridge"}


def on_toys(name, toy):
    """Return a method leaning on the toy population without m4 if on any."""
    kind = METHODS[name]
    settings = dict(QUICK.get(name, {}))
    if "population" in {field.name for field in dataclasses.fields(kind)}:
        settings["population"] = toy.without(["m4"])
    return kind(**settings)


@pytest.fixture(params=sorted(METHODS))
def method(request, toy):
    """Return each method in turn."""
    return on_toys(request.param, toy)


@pytest.fixture(params=sorted(set(METHODS) - FIXED_RIDGE))
def unbiased(request, toy):
    """Return each method in turn that assumes neither a brightness nor a number of samples."""
    return on_toys(request.param, toy)


@pytest.fixture
def somewhere(random_directions):
    """Return 200 pairs of directions."""
    return random_directions(200)


def rotated(w, angle):
    c, s = np.cos(angle), np.sin(angle)
    return w @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def off(one, other):
    """Return |ln one - ln other|."""
    return np.abs(np.log(one) - np.log(other))


# --- the function that comes out -----------------------------------------------------------


def test_the_result_is_positive_and_finite_wherever_a_brdf_is_defined(method, measure, somewhere):
    result = method.fit(measure())
    dense = result.table(GRID)
    for values in (result.evaluate(*somewhere), dense.values[GRID.above_horizon]):
        assert np.isfinite(values).all()
        assert (values > 0.0).all()
    assert np.array_equal(dense.mask, GRID.above_horizon)


def test_below_the_horizon_it_is_zero_and_unknown_where_a_direction_is(method, measure):
    wi = directions_from_spherical(np.array([0.5, 2.0, 0.5, 0.5]), np.zeros(4))
    wo = directions_from_spherical(np.array([0.3, 0.3, 3.0, 0.3]), np.ones(4))
    wi[3] = np.nan
    values = method.fit(measure()).evaluate(wi, wo)
    assert (values[0] > 0.0).all()
    assert (values[1:3] == 0.0).all()
    assert np.isnan(values[3]).all()


def test_the_table_is_the_function_at_the_nodes(method, measure):
    result = method.fit(measure())
    at_nodes = result.evaluate(*GRID.directions(GRID.cells))
    assert off(result.table(GRID).values.reshape(-1, 3)[GRID.cells], at_nodes).max() < 1e-4


def test_exchanging_light_and_detector_changes_nothing(method, measure, somewhere):
    wi, wo = somewhere
    result = method.fit(measure())
    assert off(result.evaluate(wi, wo), result.evaluate(wo, wi)).max() < 1e-4


def test_samples_with_light_and_detector_exchanged_are_the_same_samples(method, measure, somewhere):
    samples = measure()
    swapped = dataclasses.replace(samples, wi=samples.wo, wo=samples.wi)
    one, other = (method.fit(given).evaluate(*somewhere) for given in (samples, swapped))
    assert off(one, other).max() < 1e-2


def test_the_residuals_are_those_of_the_result(method, measure):
    samples = measure()
    result = method.fit(samples)
    expected = np.log(samples.value / result.evaluate(samples.wi, samples.wo))
    assert np.allclose(result.residuals, expected, atol=1e-4)


def test_the_table_names_the_channels_of_the_samples(method, measure):
    samples = measure(bands=4)
    table = method.fit(samples).table(GRID)
    assert table.channels == samples.channels
    assert np.array_equal(table.wavelengths, samples.wavelengths)


def test_uncertainty_is_positive_or_refused_in_words(method, measure, somewhere):
    result = method.fit(measure())
    if result.model.stddev(*somewhere) is None:
        with pytest.raises(UsageError, match=method.name):
            result.stddev(*somewhere)
    else:
        assert result.stddev(*somewhere).shape == (200, 3)
        assert (result.stddev(*somewhere) > 0.0).all()


# --- what must not matter ------------------------------------------------------------------


def test_the_same_fit_twice_is_the_same_to_the_bit(method, measure, somewhere):
    samples = measure()
    one, other = method.fit(samples), method.fit(samples)
    assert np.array_equal(one.evaluate(*somewhere), other.evaluate(*somewhere))
    assert np.array_equal(one.channel_weights, other.channel_weights)
    assert one.history == other.history


def test_the_order_of_the_samples_does_not_matter(method, measure, rng, somewhere):
    samples = measure()
    order = rng.permutation(len(samples))
    one, other = method.fit(samples), method.fit(samples.subset(order))
    assert off(one.evaluate(*somewhere), other.evaluate(*somewhere)).max() < 1e-2
    assert np.allclose(one.residuals[order], other.residuals, atol=1e-2)
    assert np.array_equal(one.outliers[order], other.outliers)


def test_the_order_of_the_channels_does_not_matter(method, measure, somewhere):
    samples = measure(bands=5)
    order = [3, 0, 4, 2, 1]
    one, other = method.fit(samples), method.fit(samples.select_channels(order))
    difference = off(one.evaluate(*somewhere)[:, order], other.evaluate(*somewhere))
    assert difference.max() < 1e-2


def test_turning_the_sample_about_its_normal_changes_nothing(method, measure, somewhere):
    samples = measure()
    turned = dataclasses.replace(samples, wi=rotated(samples.wi, 1.0), wo=rotated(samples.wo, 1.0))
    one, other = (method.fit(given).evaluate(*somewhere) for given in (samples, turned))
    assert off(one, other).max() < 1e-2


@pytest.mark.parametrize("factor", [0.125, 64.0])
def test_scaling_the_values_scales_the_result(unbiased, measure, somewhere, factor):
    samples = measure()
    one = unbiased.fit(samples).evaluate(*somewhere)
    other = unbiased.fit(samples.with_value(factor * samples.value)).evaluate(*somewhere)
    kept = one > 1e-4  # what is held at a smallest value does not scale
    assert kept.mean() > 0.9
    assert off(factor * one, other)[kept].max() < 1e-2


@pytest.mark.parametrize("metric", ["linear", "root", "log"])
@pytest.mark.parametrize("name", ["correction", "global", "local"])
def test_scaling_scales_the_result_under_every_error_metric(name, metric, toy, measure, somewhere):
    kind = METHODS[name]
    leaning = {} if name == "local" else {"population": toy}
    method = kind(error_metric=metric, **leaning, **QUICK.get(name, {}))
    samples = measure()
    one = method.fit(samples).evaluate(*somewhere)
    other = method.fit(samples.with_value(16.0 * samples.value)).evaluate(*somewhere)
    kept = one > 1e-4
    assert kept.mean() > 0.5  # linear splines dip below zero, and are held above it
    assert off(16.0 * one, other)[kept].max() < 1e-2


def test_rows_that_cannot_be_used_change_nothing_at_all(method, measure, somewhere):
    samples = measure()
    wi = np.vstack([samples.wi, samples.wi[:4]])
    wo = np.vstack([samples.wo, samples.wo[:4]])
    value = np.vstack([samples.value, np.full((4, 3), 99.0)])
    value[-1] = np.nan  # not finite
    wi[-2, 2] *= -1.0  # below the horizon
    wo[-3] *= 2.0  # not a direction
    more = Samples(wi=wi, wo=wo, value=value)
    more = more.with_flags(np.arange(len(more)) == len(more) - 4, Flag.REJECTED)
    shuffled = np.random.default_rng(0).permutation(len(more))
    back = np.argsort(np.argsort(shuffled[np.sort(np.argsort(shuffled)[:150])]))
    more = more.subset(shuffled)
    good = np.flatnonzero(more.usable.any(axis=1))
    one, other = method.fit(samples.subset(back)), method.fit(more)
    assert np.array_equal(one.evaluate(*somewhere), other.evaluate(*somewhere))
    assert np.array_equal(one.residuals, other.residuals[good])
    assert np.array_equal(one.weights, other.weights[good])
    assert one.history == other.history
    bad = np.setdiff1d(np.arange(len(more)), good)
    assert (other.weights[bad] == 0.0).all()
    assert np.isnan(other.residuals[bad]).all()
    assert not other.outliers[bad].any()


def test_measuring_everything_twice_does_no_harm(unbiased, measure, somewhere):
    samples = measure()
    twice = samples.subset(np.tile(np.arange(len(samples)), 2))
    one, other = (unbiased.fit(given).evaluate(*somewhere) for given in (samples, twice))
    assert np.median(off(one, other)) < 0.01
    assert off(one, other).max() < 0.5


def test_a_missing_channel_of_a_sample_leaves_the_others_in_use(method, measure, somewhere):
    samples = measure()
    value = samples.value.copy()
    value[::10, 1] = np.nan
    result = method.fit(samples.with_value(value))
    assert np.isfinite(result.evaluate(*somewhere)).all()
    assert np.isnan(result.residuals[::10, 1]).all()
    assert np.isfinite(result.residuals[::10, 0]).all()
    assert (result.channel_weights[::10, 1] == 0.0).all()
    assert (result.weights[::10] > 0.0).all()


# --- how many there are --------------------------------------------------------------------


@pytest.mark.parametrize("bands", [1, 31])
def test_any_number_of_channels_will_do(method, measure, somewhere, bands):
    result = method.fit(measure(bands=bands))
    assert result.evaluate(*somewhere).shape == (200, bands)
    assert result.table(GRID).values.shape == (*GRID.shape, bands)
    assert result.channel_weights.shape == (150, bands)
    assert result.weights.shape == (150,)


@pytest.mark.parametrize("count", [1, 3])
def test_a_handful_of_samples_ends_in_a_named_outcome(method, measure, somewhere, count):
    result = method.fit(measure(n=count))
    assert result.outcome is Outcome.TOO_FEW_SAMPLES
    assert not result.outcome.ok
    values = result.evaluate(*somewhere)
    assert np.isfinite(values).all()
    assert (values > 0.0).all()


def test_samples_of_one_corner_give_a_finite_result_everywhere(method, measure):
    samples = measure(n=2000)
    theta_h = samples.half_diff[0]
    result = method.fit(samples.subset(np.argsort(theta_h)[:60]))
    values = result.table(GRID).values[GRID.above_horizon]
    assert np.isfinite(values).all()
    assert (values > 0.0).all()


def test_nothing_to_fit_is_refused_in_words(method, measure):
    samples = measure(n=10)
    with pytest.raises(SampleError, match="0 usable samples of 10"):
        method.fit(samples.with_value(np.full((10, 3), np.nan)))


# --- settings and records ------------------------------------------------------------------


def test_settings_are_frozen_and_equal_if_alike(method):
    field = dataclasses.fields(method)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(method, field, None)
    assert method == dataclasses.replace(method)


def test_the_record_is_json_and_names_method_population_and_outcome(method, measure):
    samples = measure()
    value = samples.value.copy()
    value[0] *= 30.0
    value[1, 0] = np.nan
    record = json.loads(json.dumps(method.fit(samples.with_value(value)).record(), allow_nan=False))
    assert record["method"]["name"] == method.name
    assert set(record["method"]) == {"name", *(f.name for f in dataclasses.fields(method))}
    assert record["outcome"]["advice"]
    assert record["samples"]["count"] == record["samples"]["usable"] == 150
    if hasattr(method, "population"):
        assert record["population"]["materials"] == 9
        assert record["population"]["members"] == 10


def test_progress_starts_at_nothing_and_ends_at_everything(method, measure):
    told = {}

    def listen(label, done, total):
        told.setdefault(label, []).append((done, total))

    method.fit(measure(), listen).table(GRID, listen)
    assert told
    for steps in told.values():
        assert steps[0][0] == 0
        assert steps[-1][0] == steps[-1][1]
        assert [done for done, _ in steps] == sorted(done for done, _ in steps)


NONSENSE = [
    ("correction", "gamma", 0.0),
    ("correction", "gamma", np.inf),
    ("correction", "softening", -1.0),
    ("correction", "tolerance", np.nan),
    ("correction", "iterations", -1),
    ("correction", "iterations", 2.5),
    ("correction", "damping", 0.0),
    ("correction", "damping", np.nan),
    ("correction", "sigma_limit", 1.0),
    ("correction", "sigma_limit", np.nan),
    ("correction", "error_metric", "cubic"),
    ("global", "error_metric", "squared"),
    ("pca_ridge", "eta", 0.0),
    ("pca_ridge", "eta", np.inf),
    ("pca_ridge", "epsilon", -1.0),
    ("compact", "components", 0),
    ("compact", "residual_amplitude", 0.0),
    ("compact", "noise_floor", np.nan),
    ("compact", "steps", 1.5),
    ("local", "error_metric", ""),
    ("local", "smoothing", 0.0),
    ("local", "smoothing", np.inf),
    ("local", "n_theta_h", 3),
    ("local", "n_phi_d", 4.5),
    ("tabulated", "kernel", "gaussian"),
    ("tabulated", "neighbors", 7),
    ("tabulated", "neighbors", np.nan),
]


@pytest.mark.parametrize(("name", "field", "value"), NONSENSE)
def test_nonsense_is_refused_naming_the_setting_and_the_value(name, field, value):
    with pytest.raises(UsageError, match=field) as error:
        METHODS[name](**{field: value})
    assert str(value) in str(error.value)


def test_the_default_method_is_the_posterior(monkeypatch, measure):
    asked = []
    monkeypatch.setattr(Posterior, "fit", lambda self, *given: asked.append(self))
    fit(measure(n=10))
    assert asked == [Posterior()]
