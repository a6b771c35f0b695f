"""`Compact`: many fits at once are the fits one by one, on any array library."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from brdfit.grid import MERL_GRID, Grid
from brdfit.linalg import CoefficientPosterior
from brdfit.populations import VALUE_FLOOR
from brdfit.progress import silent
from brdfit.reconstruct import Compact, Outcome
from brdfit.reconstruct.compact import Block, CompactModel
from brdfit.reconstruct.compact.block import problems
from brdfit.reconstruct.compact.corners import Carriage, Corners, interpolated
from brdfit.reconstruct.compact.solve import Search, solve
from brdfit.reconstruct.slabs import filled
from brdfit.samples import Samples

MEMBERS = [f"m{index}" for index in range(9)]


@pytest.fixture(scope="module")
def method(toy):
    """Return the method, leaning on the toys without m4."""
    return Compact(population=toy.without(["m4"]))


@pytest.fixture(scope="module")
def basis(method):
    """Return what it leans on."""
    return method.basis()


def spoiled(samples, share, seed):
    """Return the samples with a share of the rows multiplied by a factor in [1/10, 10]."""
    rng = np.random.default_rng(seed)
    wrong = rng.permutation(len(samples))[: round(share * len(samples))]
    value = samples.value.copy()
    value[wrong] *= np.exp(rng.uniform(-np.log(10.0), np.log(10.0), (len(wrong), 1)))
    return samples.with_value(value), wrong


def incomplete(samples, seed):
    """Return the samples with missing channels, missing rows and values at the noise floor."""
    rng = np.random.default_rng(seed)
    value = samples.value.copy()
    value[rng.permutation(len(samples))[:4], rng.integers(0, 3)] = np.nan
    value[rng.integers(0, len(samples))] = np.nan
    value[rng.permutation(len(samples))[:2], 1] = 0.0
    return samples.with_value(value)


@pytest.fixture(scope="module")
def shared(measure):
    """Return items of 64 samples in the same directions, a fifth of them wrong."""
    return [spoiled(measure(m, n=64, seed=7), 0.2, i)[0] for i, m in enumerate(MEMBERS * 3)]


@pytest.fixture(scope="module")
def mixed(measure, shared):
    """Return items of all sorts: lengths, gaps, bounds, stated noise."""
    own = [spoiled(measure(m, n=30 + 9 * i, seed=i), 0.2, i)[0] for i, m in enumerate(MEMBERS)]
    with_noise = dataclasses.replace(own[0], sigma=0.05 * own[0].value)
    gaps = [incomplete(samples, i) for i, samples in enumerate(own)]
    return [*own, with_noise, *gaps, *shared[:3]]


def logs_of(result, basis, where):
    """Return ln f_r (items, n, c)."""
    return np.stack(
        [np.log(CompactModel(basis, z.T).evaluate(*where)) for z in result.coefficients]
    )


# --- the same answers ----------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["shared", "mixed", "shared with gaps"])
def test_many_at_once_are_the_same_as_one_by_one(kind, request, method, basis, random_directions):
    where = random_directions(300)
    items = request.getfixturevalue(kind.split()[0])
    if "gaps" in kind:
        items = [incomplete(samples, i) if i % 2 else samples for i, samples in enumerate(items)]
    found = method.fit_block(Block.of(items), basis)
    starts = np.cumsum([0, *map(len, items)])
    for i, samples in enumerate(items):
        single = method.fit(samples)
        off = np.abs(np.log(single.evaluate(*where)) - logs_of(found, basis, where)[i])
        assert off.max() < 1e-5
        weights = found.responsibility[starts[i] : starts[i + 1]]
        assert np.allclose(weights, single.channel_weights.max(axis=1), atol=1e-5)
        assert found.outliers[i] == single.outliers.sum()
        assert found.outcomes[i] is single.outcome


def test_the_answer_of_an_item_hangs_on_no_neighbour(method, basis, shared):
    alone = method.fit_block(Block.of(shared[:2]), basis)
    wild = shared[0].with_value(shared[0].value * 1e6)
    dark = shared[0].with_value(np.full((64, 3), np.nan))
    among = method.fit_block(Block.of([wild, *shared[5:], shared[1], dark, shared[0]]), basis)
    assert np.allclose(among.coefficients[[-1, -3]], alone.coefficients[[0, 1]], atol=1e-7)


def test_an_item_that_cannot_be_fitted_says_why_and_the_rest_go_on(method, basis, shared):
    dark = shared[1].with_value(np.full((64, 3), np.nan))
    one_dark = shared[2].with_value(shared[2].value * [1.0, 0.0, 1.0])
    found = method.fit_block(Block.of([shared[0], dark, one_dark, shared[3]]), basis)
    assert set(found.failures) == {1, 2}
    assert "64 samples" in found.failures[1]
    assert "channel G" in found.failures[2]
    assert [outcome is None for outcome in found.outcomes] == [False, True, True, False]
    assert np.isnan(found.coefficients[[1, 2]]).all()
    assert np.isfinite(found.coefficients[[0, 3]]).all()


def test_items_of_other_channels_are_refused_by_name(measure):
    with pytest.raises(ValueError, match="channels"):
        Block.of([measure(n=20), measure(n=20, bands=4)])


# --- on a grid ------------------------------------------------------------------------------


@pytest.mark.parametrize("grid", [Grid(90, 20, 24), Grid(17, 13, 9), MERL_GRID])
def test_every_cell_of_the_table_is_the_reconstruction_there(grid, method, measure):
    result = method.fit(measure(n=64))
    values = result.table(grid).values
    assert values.dtype == np.float32
    assert not values[~grid.above_horizon].any()
    cells = np.random.default_rng(2).permutation(grid.cells)[:4000]
    found = np.log(values.reshape(grid.size, -1)[cells])
    assert np.abs(found - np.log(result.evaluate(*grid.directions(cells)))).max() < 1e-5


def test_where_hardly_a_corner_is_above_the_horizon_the_nearest_answers():
    # an odd number of azimuths: none at 90 degrees, where directions go the lowest
    grid, other = Grid(9, 4, 3), Grid(40, 41, 42)
    table = np.random.default_rng(1).normal(size=(grid.cells.size + 1, 6)).astype(np.float32)
    table[-1] = 0.0
    put = Carriage.between(grid, other).of(table, np.arange(6.0))
    found = np.log(filled(other, 6, put, silent)[0].reshape(other.size, -1)[other.cells])
    corners = Corners.of(grid).at(*other.half_diff(other.cells))
    expected = interpolated(table, *corners) + np.arange(6.0)
    assert len(Carriage.between(grid, other).odd) > 0
    assert np.allclose(found, expected, atol=1e-5)


# --- any array library ---------------------------------------------------------------------


def of_strict():
    """Return what makes an array of the standard and nothing else."""
    from array_api_strict import asarray

    return asarray


def of_torch():
    """Return what makes a tensor of PyTorch, on the processor."""
    torch = pytest.importorskip("torch", reason="PyTorch (the extra gpu) is not installed")
    return lambda array: torch.from_numpy(np.ascontiguousarray(array))


@pytest.mark.parametrize("library", [of_strict, of_torch])
def test_another_array_library_gives_the_same(library, method, basis, mixed, shared):
    to = library()
    where = mixed[0].wi[:20], mixed[0].wo[:20]
    for items in (mixed, shared):
        block = Block.of(items)
        one, other = method.fit_block(block, basis), method.fit_block(block, basis, to)
        assert np.allclose(one.responsibility, other.responsibility, atol=1e-7)
        assert np.array_equal(one.steps, other.steps)
        off = logs_of(one, basis, where) - logs_of(other, basis, where)
        assert np.abs(off).max() < 1e-5


# --- the right answers ---------------------------------------------------------------------


def test_where_it_rests_is_the_posterior_mean_of_its_own_weights(basis, shared):
    block = Block.of(shared[:4])
    problem = next(problems(block, basis, 1e-4))
    found = solve(problem.items, Search(steps=200))
    for i in range(4):
        weights = found.responsibility[i] / (found.width[i] ** 2 + problem.scatter[i])
        posterior = CoefficientPosterior.of(problem.items.features, weights)
        z = posterior.solve(problem.items.y[i, 0].T)
        assert np.abs(problem.items.features @ (z - found.coefficients[i, 0].T)).max() < 5e-3
        deviation = np.sqrt(np.trace(posterior.apply(problem.items.spread)))
        assert found.deviation[i] == pytest.approx(deviation, rel=0.01)


def test_wrong_samples_are_named_and_hardly_matter(method, measure, toy, random_directions):
    where = random_directions(400)
    truth = np.log(np.maximum(toy.subset(["m4"]).evaluate(*where)[:, 0], VALUE_FLOOR))
    clean = measure("m4", n=64, seed=3)
    dirty, wrong = spoiled(clean, 0.2, 3)
    at_worst = np.abs(np.log(dirty.value / clean.value))[wrong].max(axis=1)
    result, without = method.fit(dirty), method.fit(clean)
    assert result.outliers[wrong[at_worst > 0.7]].all()
    assert result.outliers.sum() <= len(wrong) + 2
    off = [np.abs(np.log(r.evaluate(*where)) - truth).mean() for r in (result, without)]
    assert off[0] < 1.3 * off[1] + 0.01


def test_the_uncertainty_grows_with_the_distance_and_shrinks_with_the_samples(method, measure):
    few, many = (method.fit(measure("m4", n=n)) for n in (20, 200))
    assert many.history[0]["deviation"] < few.history[0]["deviation"]
    at = measure("m4", n=200)
    assert many.stddev(at.wi, at.wo).mean() < few.stddev(at.wi, at.wo).mean()
    corner = at.subset(np.argsort(at.half_diff[0])[:40])
    near = method.fit(corner).stddev(at.wi, at.wo)[:, 0]
    order = np.argsort(at.half_diff[0])
    assert near[order[:40]].mean() < near[order[-40:]].mean()


def test_the_first_components_hold_the_most_variance(basis):
    variance = (basis.rows[:, 1:].astype(np.float64) ** 2).mean(axis=0)
    # of the grid's cells, which are not those that they were found on
    assert (np.diff(variance) < 0.05 * variance[:-1]).all()
    assert variance[:8].sum() > 0.9 * variance.sum()


def test_a_member_is_described_by_its_leading_components(toy, basis, random_directions):
    where = random_directions(500)
    truth = np.log(np.maximum(toy.subset(["m2"]).evaluate(*where)[:, 0], VALUE_FLOOR))
    mean, phi = basis.at(*where)
    z = np.linalg.lstsq(phi, truth - mean[:, None], rcond=None)[0]
    assert np.abs(mean[:, None] + phi @ z - truth).mean() < 0.02
    assert np.allclose(basis.log_value(z, *where), mean[:, None] + phi @ z, atol=1e-4)


def test_a_handful_of_samples_is_called_that(method, basis, measure):
    found = method.fit_block(Block.of([measure(n=2), measure(n=64)]), basis)
    assert found.outcomes[0] is Outcome.TOO_FEW_SAMPLES
    assert found.outcomes[1].ok


def test_sigma_of_some_items_only_is_no_sigma_for_the_others(method, basis, measure):
    plain = measure(n=40)
    stated = dataclasses.replace(plain, sigma=0.5 * plain.value)
    found = method.fit_block(Block.of([plain, stated]), basis)
    assert np.allclose(
        found.coefficients[0], method.fit_block(Block.of([plain]), basis).coefficients
    )
    assert found.deviation[1] > 1.5 * found.deviation[0]
    assert isinstance(Block.of([plain]).samples, Samples)


def test_bands_that_miss_other_samples_are_each_fitted_from_their_own(method, measure):
    samples = measure(n=80, bands=31)
    value = samples.value.copy()
    gone = np.random.default_rng(7).random(value.shape) < 0.2
    value[gone] = np.nan
    result = method.fit(samples.with_value(value))
    found = result.evaluate(samples.wi, samples.wo)
    assert np.median(np.abs(np.log(found / samples.value))) < 0.06
