"""What sets `Posterior` apart: it judges samples by one another, and says how sure it is."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.geometry import directions_from_half_diff
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations.store import stored_cells
from brdfit.progress import silent
from brdfit.reconstruct import Posterior
from brdfit.reconstruct.posterior.calibration import Calibration, beyond_samples
from brdfit.reconstruct.posterior.principal import GridComponents, axes_of, principal_basis
from brdfit.reconstruct.posterior.prior import population_prior
from brdfit.reconstruct.posterior.search import Search
from brdfit.reconstruct.posterior.section import SECTION


@pytest.fixture
def method(toy):
    return Posterior(population=toy.without(["m4"]), residual_size=200)


def spoilt(samples, rows, factor):
    value = samples.value.copy()
    value[rows] *= factor
    return samples.with_value(value)


def off(one, other):
    return np.abs(np.log(one) - np.log(other))


def test_planted_outliers_are_named_and_move_little(method, measure):
    samples = measure(n=200)
    wrong = np.arange(0, 200, 4)
    result = method.fit(spoilt(samples, wrong, np.where(wrong % 8, 8.0, 0.1)[:, None]))
    named = np.flatnonzero(result.outliers)
    assert set(wrong) <= set(named)
    assert len(named) <= 1.1 * len(wrong)
    clean = method.fit(samples)
    assert np.median(off(result.evaluate(*samples.safe_directions), samples.value)) < 0.05
    assert np.median(off(clean.evaluate(*samples.safe_directions), samples.value)) < 0.05


def test_a_lobe_that_no_member_has_is_material(method, measure):
    samples = measure(n=400)
    theta_h = samples.half_diff[0]
    lobe = 1.0 + 6.0 * np.exp(-((theta_h - 0.6) ** 2) / 0.02)
    result = method.fit(samples.with_value(samples.value * lobe[:, None]))
    inside = lobe > 3.0
    assert inside.sum() > 10
    assert result.outliers[inside].mean() < 0.2


def test_the_order_of_samples_changes_nothing(method, measure):
    samples = measure()
    order = np.random.default_rng(3).permutation(len(samples))
    one, other = method.fit(samples), method.fit(samples.subset(order))
    assert np.array_equal(one.weights[order], other.weights)
    assert np.array_equal(
        one.evaluate(samples.wi, samples.wo), other.evaluate(samples.wi, samples.wo)
    )


def test_a_fit_is_the_same_to_the_bit_when_it_is_repeated(method, measure):
    samples = measure()
    one, other = method.fit(samples).table(Grid(6, 5, 8)), method.fit(samples).table(Grid(6, 5, 8))
    assert np.array_equal(one.values, other.values)


def test_it_is_surer_where_it_was_measured(method, measure):
    samples = measure()
    near = samples.half_diff[0] < 0.4
    result = method.fit(samples.subset(near))
    deviation = result.stddev(samples.wi, samples.wo)
    assert deviation.shape == samples.value.shape
    assert np.median(deviation[near]) < np.median(deviation[~near])


def test_more_samples_than_the_search_looks_at_all_count(method, measure):
    samples = measure(n=3200)
    result = method.fit(spoilt(samples, np.arange(0, 3200, 5), 9.0))
    assert result.outliers[::5].mean() > 0.9
    assert result.outliers.mean() < 0.25


def test_samples_that_had_no_say_are_judged_by_the_result(toy, measure, monkeypatch):
    samples = measure(n=3000)
    wrong = np.arange(0, 3000, 5)
    method = Posterior(population=toy.without(["m4"]), residual_size=200)
    monkeypatch.setattr(Posterior, "search", lambda self: Search(most=1500, centres=200))
    result = method.fit(spoilt(samples, wrong, 9.0))
    assert result.outliers[wrong].mean() > 0.9
    assert result.outliers.mean() < 0.25
    assert np.isfinite(result.residuals).all()
    found = result.evaluate(*samples.safe_directions)
    assert np.median(off(found, samples.value)) < 0.05


def test_a_stated_sigma_lowers_the_say_of_a_sample(method, measure):
    samples = measure(n=60)
    at = samples.wi[:1], samples.wo[:1]

    def moved(share):
        """Return how far a change of one value by 2 % moves the fit there."""
        sigma = np.full(samples.value.shape, 1e-4)
        sigma[0] = share * samples.value[0]
        fits = [
            method.fit(dataclasses.replace(one, sigma=sigma)).evaluate(*at)
            for one in (samples, spoilt(samples, [0], 1.02))
        ]
        return off(*fits).max()

    assert 4.0 * moved(0.5) < moved(0.001)


def test_components_give_the_columns_back():
    logs = np.random.default_rng(2).normal(size=(60, 6))
    axes = axes_of(logs, 1e-14)
    mean = logs.mean(axis=1, keepdims=True)
    assert np.allclose(mean + (logs - mean) @ axes @ axes.T, logs, atol=1e-6)


def test_the_prior_has_the_mean_and_the_covariance_of_the_weighted_columns():
    axes = np.random.default_rng(4).normal(size=(9, 4))
    weights = np.arange(9.0)
    prior = population_prior(axes, weights)
    assert np.allclose(prior.mean, np.average(axes, axis=0, weights=weights))
    expected = np.cov(axes.T, aweights=weights, ddof=0)
    assert np.allclose(prior.factor @ prior.factor.T, expected)


def test_half_the_rows_as_centres_say_nearly_the_same(toy, measure):
    samples = measure(n=240)
    materials = toy.without(["m4"])
    whole = Posterior(population=materials).fit(samples)
    sparse = Posterior(population=materials, residual_size=120).fit(samples)
    at = measure(n=100, seed=9).safe_directions
    assert np.median(off(whole.evaluate(*at), sparse.evaluate(*at))) < 0.01
    ratio = sparse.stddev(*at) / whole.stddev(*at)
    assert 0.8 < np.median(ratio) < 1.5


def test_the_table_is_the_reconstruction_at_the_nodes(method, measure):
    result = method.fit(measure(n=200))
    grid = Grid(30, 20, 24)
    table = result.table(grid)
    at = grid.directions(grid.cells)
    assert np.median(off(table.evaluate(*at), result.evaluate(*at))) < 1e-3


def test_a_table_of_one_that_follows_a_lobe_is_the_reconstruction_too(method, measure, monkeypatch):
    search = Search(centres=200, shapes=((1.0, 1.0),), following=((1.0, 1.0),), worth=-10.0)
    monkeypatch.setattr(Posterior, "search", lambda self: search)
    result = method.fit(measure(n=200))
    assert result.history[0]["residual_lobe"] == search.lobe
    at = MERL_GRID.directions(np.random.default_rng(2).choice(MERL_GRID.cells, 3000))
    difference = off(result.table().evaluate(*at), result.evaluate(*at))
    assert np.quantile(difference, 0.99) < 2e-3
    assert difference.max() < 1e-2


def test_the_section_is_where_light_and_camera_are_equally_high(toy):
    basis = principal_basis(toy)
    section = basis.on_section()
    theta_h, theta_d = np.meshgrid(SECTION.theta_h, SECTION.theta_d, indexing="ij")
    directions = directions_from_half_diff(theta_h, theta_d, np.full_like(theta_h, np.pi / 2))
    wi, wo = (d.reshape(-1, 3) for d in directions)
    np.testing.assert_allclose(wi[:, 2], wo[:, 2], atol=1e-12)
    np.testing.assert_allclose(section.reshape(len(wi), -1), basis.at(wi, wo), atol=1e-4)


def test_every_cell_of_the_table_is_the_reconstruction_there(method, measure):
    result = method.fit(measure(n=200))
    grid = Grid(30, 20, 24)
    dense = result.model.dense(grid, silent)
    assert dense.dtype == np.float32
    assert not dense[~grid.above_horizon].any()
    found = dense.reshape(grid.size, -1)[grid.cells]
    assert off(found, result.evaluate(*grid.directions(grid.cells))).max() < 1e-3


@pytest.mark.parametrize("bilateral", [True, False])
def test_the_rows_of_one_theta_h_are_those_of_its_cells(bilateral):
    grid = Grid(9, 8, 10)
    cells, expand = stored_cells(grid, bilateral)
    stored = GridComponents(grid, bilateral, cells[:, None].astype(np.float32))
    found = []
    for i in range(grid.n_theta_h):
        rows, row_of = stored.ring(i)
        found.append(rows[row_of, 0])
    assert np.array_equal(np.concatenate(found)[grid.cells], cells[expand])


def test_the_leading_directions_are_the_largest_in_ln_f_r_and_the_prior_is_the_same():
    rng = np.random.default_rng(8)
    sizes = np.array([30.0, 1.0, 0.1, 0.01])
    axes = np.linalg.qr(rng.normal(size=(12, 4)))[0]
    components = np.hstack([np.zeros((50, 1)), rng.normal(size=(50, 4)) * sizes])
    weights = rng.random(12)
    plain, ordered = population_prior(axes, weights), population_prior(axes, weights, sizes)
    assert np.allclose(plain.factor @ plain.factor.T, ordered.factor @ ordered.factor.T)
    variance = (ordered.features(components)[:, :-1] ** 2).sum(axis=0)
    assert variance[0] > 0.9 * variance.sum()
    assert np.allclose(ordered.leading(1).factor, ordered.factor[:, :1])


def test_as_many_of_new_samples_lie_within_the_deviations_as_it_says(method, measure):
    result = method.fit(measure(n=300, noise=0.05))
    new = measure(n=2000, noise=0.05, seed=12)
    found = result.evaluate(new.wi, new.wo)
    spread = np.hypot(result.stddev(new.wi, new.wo), result.model.noise)
    z = off(new.value, found) / spread
    assert 0.60 < (z < 1.0).mean() < 0.76
    assert 0.90 < (z < result.deviations(0.95)).mean() < 0.985
    assert result.deviations(0.683) == pytest.approx(1.0, abs=0.01)
    with pytest.raises(UsageError, match="between 0 and 1"):
        result.deviations(95)


def test_calibration_counts_what_was_left_out_and_not_outliers():
    rng = np.random.default_rng(2)
    z = np.concatenate([2.0 * rng.standard_normal(4000), np.full(2000, 50.0)])
    r = np.concatenate([np.ones(4000), np.zeros(2000)])
    found = Calibration.of(z[:, None] ** 2, r, 4.0)
    assert found.unit == pytest.approx(2.0, rel=0.05)
    assert found.deviations(0.95) == pytest.approx(1.96, rel=0.05)


def test_a_few_samples_do_not_calibrate_alone():
    found = Calibration.of(np.full((3, 2), 1e-12), np.ones(3), 4.0)
    assert found.unit > 0.2


def test_beyond_the_samples_more_is_stated_and_among_them_what_was_known():
    variance = np.geomspace(1e-6, 1e3, 400)
    stated = beyond_samples(variance, 0.01)
    among = variance <= 0.03
    assert np.array_equal(stated[among], variance[among])
    assert (np.diff(stated) > 0.0).all()
    growth = stated / variance
    assert (np.diff(growth) >= -1e-12).all()
    assert growth.max() == pytest.approx(4.0)
    np.testing.assert_allclose(beyond_samples(7.0 * variance, 0.07), 7.0 * stated)


def test_what_lies_beyond_the_samples_is_stated_with_more_than_the_process_says(method, measure):
    samples = measure()
    near = samples.half_diff[0] < 0.4
    model = method.fit(samples.subset(near)).model
    far = samples.subset(~near)
    components = model.basis.at(far.wi, far.wo)
    process = model.winner.variance(components, far.half_diff)
    stated = model.stddev(far.wi, far.wo)[:, 0] ** 2 / model.calibration.unit**2
    assert (stated >= process * (1.0 - 1e-9)).all()
    assert np.median(stated / process) > 1.5


@pytest.mark.parametrize("seed", [0, 2])
def test_a_crowd_of_outliers_that_is_the_majority_is_not_the_material(toy, measure, seed):
    # four fifths; told from others by a normal, a tenth of those of seed 2 is believed
    samples = measure(n=120, noise=0.0)
    rng = np.random.default_rng(seed)
    wrong = rng.permutation(120) < 96
    elsewhere = rng.random((120, 1)) * np.percentile(samples.value, 95, axis=0)
    spoilt = samples.with_value(np.where(wrong[:, None], elsewhere, samples.value))
    named = Posterior(population=toy.without(["m4"])).fit(spoilt).outliers
    assert named[wrong].mean() > 0.95
    assert named[~wrong].mean() < 0.25
