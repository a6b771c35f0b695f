"""What is lowered so that no table reflects more than it receives, and what is left alone."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import Grid
from brdfit.models import Ggx
from brdfit.physics import AlbedoPlan, directional_albedo, limit_energy
from brdfit.table import Table

GRID = Grid(24, 24, 24)


def table_of(brdf, grid: Grid = GRID, valid=None) -> Table:
    cells = brdf.evaluate(*grid.directions(grid.cells))
    values = np.zeros((grid.size, cells.shape[1]))
    values[grid.cells] = cells
    return Table(values=values.reshape(*grid.shape, -1), grid=grid, valid=valid)


@pytest.fixture
def bright() -> Table:
    """Return a table of three channels: one that could exist, two that could not."""
    return table_of(Ggx(diffuse=[0.1, 0.6, 0.9], f0=0.5, alpha=0.3))


def share_left(table: Table, limited: Table):
    return limited.values[table.mask] / table.values[table.mask]


def test_the_plan_is_the_evaluation_of_the_table_holes_included():
    rng = np.random.default_rng(3)
    table = table_of(Ggx(alpha=0.1, diffuse=[0.1, 0.2]), valid=rng.random(GRID.shape) > 0.3)
    theta = np.radians([0.0, 33.0, 70.0, 88.0])
    plan = AlbedoPlan.build(GRID, table.mask, theta)
    np.testing.assert_allclose(plan.of(table), directional_albedo(table, theta), rtol=1e-12)


def test_afterwards_no_incidence_reflects_more_than_the_limit(bright):
    result = limit_energy(bright)
    assert result.before.max() > 1.3
    assert result.after.max() <= 1.0
    assert result.excess == 0.0
    at = np.radians([0.0, 10.5, 47.3, 71.9, 88.5, 89.6])
    assert directional_albedo(result.table, at).max() < 1.0 + 1e-3


def test_no_more_is_taken_than_has_to_be(bright):
    result = limit_energy(bright)
    # a node answers for what lies within half a step of it
    near = np.arange(0, 2 * GRID.n_theta_d, 2)[:, None] + [-1, 0, 1]
    near[0, 0] = 0
    over = (result.before[near] > 1.01).any(axis=1)
    np.testing.assert_allclose(result.after[near].max(axis=1)[over], 1.0, atol=2e-3)


def test_values_only_go_down_and_a_channel_that_could_exist_stays_as_it_is(bright):
    result = limit_energy(bright)
    assert (result.table.values <= bright.values).all()
    assert np.array_equal(result.table.values[..., 0], bright.values[..., 0])
    assert 0 < result.changed <= bright.mask.sum()
    assert result.strongest == pytest.approx(share_left(bright, result.table).min())


def test_a_table_that_respects_the_limit_is_returned_itself():
    table = table_of(Ggx(diffuse=0.2, f0=0.3, alpha=0.4))
    result = limit_energy(table)
    assert result.table is table
    assert (result.changed, result.strongest, result.excess) == (0, 1.0, 0.0)


def test_another_limit_is_kept_too(bright):
    assert limit_energy(bright, limit=0.5).after.max() <= 0.5


def test_without_a_doubt_map_the_same_share_goes_everywhere_in_a_flat_excess():
    table = table_of(Ggx(diffuse=1.4, f0=0.0, alpha=1.0))
    flat = Table(values=np.full((*GRID.shape, 1), 1.4 / np.pi), grid=GRID)
    left = share_left(flat, limit_energy(flat).table)
    np.testing.assert_allclose(left, 1.0 / 1.4, rtol=0.01)
    assert table.mask.any()


def test_doubtful_values_give_way_first(bright):
    stddev = np.full(GRID.shape, 0.02)
    stddev[:, 6:] = 1.0
    left = share_left(bright, limit_energy(bright, stddev).table)
    doubtful = stddev[bright.mask] > 0.5
    assert left[~doubtful].mean() > left[doubtful].mean() + 0.05


def test_a_small_excess_is_taken_from_doubtful_values_alone():
    table = table_of(Ggx(diffuse=0.46, f0=0.64, alpha=0.5))
    stddev = np.where(np.arange(24)[None, :, None] >= 6, 1.0, 0.005) * np.ones(GRID.shape)
    result = limit_energy(table, stddev)
    assert 1.02 < result.before.max() < 1.12
    assert result.after.max() <= 1.0
    left = share_left(table, result.table)
    known = stddev[table.mask] < 0.5
    assert left[known].min() > 0.999
    assert left[~known].min() < 0.99


def test_a_value_without_doubt_never_changes_and_what_that_leaves_is_said(bright):
    stddev = np.ones(GRID.shape)
    stddev[:, :12] = 0.0
    result = limit_energy(bright, stddev)
    sure = np.broadcast_to(stddev[..., None] == 0.0, bright.values.shape)
    assert np.array_equal(result.table.values[sure], bright.values[sure])
    assert result.excess > 0.1
    assert result.strongest > 1e-3  # nothing is made black in vain


def test_a_table_that_looks_alike_from_light_and_detector_still_does(bright):
    values = limit_energy(bright).table.values
    flipped = values[:, :, (-np.arange(GRID.n_phi_d)) % GRID.n_phi_d]
    np.testing.assert_allclose(values, flipped, rtol=1e-6)


def test_missing_cells_keep_what_they_hold(bright):
    valid = np.random.default_rng(1).random(GRID.shape) > 0.2
    holed = Table(values=bright.values, grid=GRID, valid=valid)
    result = limit_energy(holed)
    assert result.after.max() <= 1.0
    assert np.array_equal(result.table.values[~holed.mask], bright.values[~holed.mask])
    assert np.array_equal(result.table.mask, holed.mask)


def test_single_precision_stays_single(bright):
    single = Table(values=bright.values.astype(np.float32), grid=GRID)
    result = limit_energy(single)
    assert result.table.values.dtype == np.float32
    assert result.after.max() <= 1.0


@pytest.mark.parametrize(
    "stddev", [np.ones((3, 3)), -np.ones(GRID.shape), np.full(GRID.shape, np.nan)]
)
def test_a_doubt_map_that_cannot_be_meant_is_refused(bright, stddev):
    with pytest.raises(UsageError, match="stddev"):
        limit_energy(bright, stddev)


def test_a_limit_of_nothing_is_refused(bright):
    with pytest.raises(UsageError, match="limit"):
        limit_energy(bright, limit=0.0)


def test_incidence_of_a_cell_is_what_its_geometry_says():
    cos_i, _ = cos_incident_outgoing(*GRID.half_diff(GRID.cells))
    wi, _ = GRID.directions(GRID.cells)
    np.testing.assert_allclose(wi[:, 2], cos_i, atol=1e-12)
