"""What is done to ln f_r of one theta_h, and that compiled loops and numpy do the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from brdfit.grid import Grid
from brdfit.linalg import thin
from brdfit.progress import silent
from brdfit.reconstruct import Compact, Posterior, slab_cells, slabs
from brdfit.reconstruct.slab_cells import (
    Between,
    Lines,
    add_rows,
    loops_if_compiled,
    plain_add_rows,
    plain_put_lines,
    plain_put_values,
    put_lines,
    put_values,
)

CHANNELS = pytest.mark.parametrize("channels", [1, 3, 7, 31])
CELLS = pytest.mark.parametrize("cells", [1, 255, 256, 700])
# odd along every axis, with cells below the horizon and without a node at 90 degrees
GRID = Grid(13, 9, 11)


@pytest.fixture
def compiled():
    if loops_if_compiled() is None:
        pytest.skip("numba is not installed: pip install 'brdfit[fast]'")


@pytest.fixture
def plain(monkeypatch):
    """A function after whose call numpy does everything."""

    def switch():
        monkeypatch.setattr(slab_cells, "loops_if_compiled", lambda: None)
        monkeypatch.setattr(thin, "_loop_if_compiled", lambda: None)

    return switch


def single(rng, *shape, size=1.0):
    return (size * rng.normal(size=shape)).astype(np.float32)


# --- what they are --------------------------------------------------------------------------


@CHANNELS
@CELLS
def test_each_cell_has_its_row_added_and_the_constant(rng, channels, cells):
    logs, rows = single(rng, channels, cells), single(rng, 50, channels)
    row_of, constant = rng.integers(50, size=cells), single(rng, channels)
    expected = logs + (rows[row_of] + constant).T
    before = rows.copy()
    for way in (add_rows, plain_add_rows):
        found = logs.copy()
        way(found, rows, row_of, constant)
        assert np.allclose(found, expected, rtol=0.0, atol=1e-6)
        assert np.array_equal(rows, before)


@CHANNELS
@CELLS
def test_values_are_exponentials_within_bounds_and_nothing_below_the_horizon(rng, channels, cells):
    logs = single(rng, channels, cells, size=20.0)
    highest = np.where(rng.random(cells) < 0.7, 30.0, -np.inf).astype(np.float32)
    expected = np.where(np.isfinite(highest), np.exp(np.clip(logs.astype(float), -30, 30)), 0).T
    for way in (put_values, lambda a, b, c: plain_put_values(a, b, np.float32(-30.0), c)):
        found = np.full((cells, channels), np.nan, dtype=np.float32)
        way(logs.copy(), highest, found)
        assert np.allclose(found, expected, rtol=3e-7, atol=0.0)
        assert not found[np.isneginf(highest)].any()


def test_the_exponential_is_one_at_zero_and_as_good_everywhere(compiled):
    logs = np.linspace(-30.0, 30.0, 1_000_001, dtype=np.float32)
    logs[0], logs[1] = 0.0, -0.0
    found = np.empty((len(logs), 1), dtype=np.float32)
    put_values(logs[None].copy(), np.full(len(logs), 30.0, dtype=np.float32), found)
    assert found[0, 0] == found[1, 0] == 1.0
    assert np.allclose(found[:, 0], np.exp(logs.astype(np.float64)), rtol=1.2e-7, atol=0.0)


def test_what_lies_between_is_read_off_a_matrix_that_wraps_around():
    matrix = np.array([[1, 0, 0], [0.25, 0.75, 0], [0, 0, 1], [0.5, 0, 0.5]], dtype=np.float32)
    found, nodes = Between.of(matrix), np.array([1.0, 10.0, 100.0], dtype=np.float32)
    one, other = nodes[found.low], nodes[found.high]
    assert np.array_equal(found.weight[0] * one + found.weight[1] * other, matrix @ nodes)
    two = np.stack([nodes, -nodes], axis=1).reshape(-1)
    each = found.each(2)
    both = each.weight[0] * two[each.low] + each.weight[1] * two[each.high]
    assert np.array_equal(both.reshape(-1, 2), np.stack([matrix @ nodes, -matrix @ nodes], axis=1))


@CHANNELS
def test_a_line_is_linear_between_nodes_then_scaled_shifted_and_put(rng, channels):
    to_d, to_phi = np.zeros((5, 4), dtype=np.float32), np.zeros((21, 7), dtype=np.float32)
    to_d[[0, 1, 1, 2, 2, 3, 4], [0, 0, 1, 1, 2, 2, 3]] = [1.0, 0.25, 0.75, 0.5, 0.5, 1.0, 1.0]
    for place in range(21):
        to_phi[place, [place // 3, (place // 3 + 1) % 7]] = 1 - place % 3 / 3, place % 3 / 3
    nodes, constant = single(rng, 2, 4, 7, channels), single(rng, channels)
    scale, kind = single(rng, 3, 21), rng.integers(3, size=(2, 5)).astype(np.int32)
    highest = np.where(rng.random((3, 21)) < 0.7, 1.0, -np.inf).astype(np.float32)
    logs = np.einsum("dm,pq,hmqc->hdpc", to_d, to_phi, nodes) * scale[kind][..., None] + constant
    most = highest[kind][..., None]
    expected = np.where(most > 0.0, np.exp(np.minimum(logs, most)), 0.0).reshape(2, 5, -1)
    lines = Lines(Between.of(to_d), Between.of(to_phi), scale, highest).each(channels)
    for way in (put_lines, plain_put_lines):
        found = np.full((2, 5, 21 * channels), np.nan, dtype=np.float32)
        way(nodes.reshape(2, 4, -1), lines, kind, np.tile(constant, 21), found)
        assert np.allclose(found, expected, rtol=1e-5, atol=0.0)


# --- tables ---------------------------------------------------------------------------------


@pytest.fixture(params=["posterior", "compact"])
def method(request, toy):
    return {"posterior": Posterior, "compact": Compact}[request.param](population=toy)


def off(one, other):
    above = GRID.above_horizon
    assert not one.values[~above].any()
    return np.abs(np.log(one.values[above]) - np.log(other.values[above])).max()


@pytest.mark.parametrize("bands", [0, 9])
def test_compiled_or_not_the_table_is_the_same(compiled, plain, method, measure, bands):
    result = method.fit(measure(n=64, bands=bands))
    free, limited = result.table(GRID), result.limited_table(GRID, albedo=0.05)
    assert limited.lowered.any()
    plain()
    assert off(free, result.table(GRID)) < 5e-6
    # the limit is sought in steps, until it is met closely enough
    assert off(limited.table, result.limited_table(GRID, albedo=0.05).table) < 1e-4


def test_the_table_does_not_depend_on_who_does_what(monkeypatch, method, measure):
    result = method.fit(measure(n=64))
    two = result.model.dense(GRID, silent)

    def alone(task, count):
        for number in reversed(range(count)):
            task(number)

    monkeypatch.setattr(slabs, "side_by_side", alone)
    assert np.array_equal(result.model.dense(GRID, silent), two)


def test_every_value_of_a_fit_is_seen_to_be_finite(method, measure):
    result = method.fit(measure(n=64))
    assert result.model.seen_dense(GRID, silent)[1]
    assert np.array_equal(result.table(GRID).mask, GRID.above_horizon)


@pytest.mark.parametrize("wrong", [0, GRID.size // 2, GRID.size - 1])
@pytest.mark.parametrize("what", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_not_finite_is_seen_wherever_it_is(wrong, what):
    def put(rings, cells):
        cells[:] = 1.0
        ring, cell = divmod(wrong, cells.shape[1])
        if rings.start <= ring < rings.stop:
            cells[ring - rings.start, cell, 1] = what

    assert not slabs.filled(GRID, 2, put, silent)[1]


def test_a_fit_whose_coefficients_are_not_finite_has_a_table_that_holds_nothing(toy, measure):
    result = Compact(population=toy).fit(measure(n=64))
    coefficients = result.model.coefficients.copy()
    coefficients[3, 0] = np.nan
    spoiled = replace(result, model=replace(result.model, coefficients=coefficients))
    values, finite = spoiled.model.seen_dense(GRID, silent)
    assert not finite
    assert np.isnan(values[GRID.above_horizon]).any(axis=1).all()
    assert not spoiled.table(GRID).mask.any()
