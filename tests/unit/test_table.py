"""A table answers from its valid cells only, at any direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_half_diff
from brdfit.grid import Grid
from brdfit.table import Table

# no two sizes equal, so that swapped axes show
GRID = Grid(7, 6, 8)
Pairs = Callable[[int], tuple[FloatArray, FloatArray]]


@pytest.fixture
def values(rng: np.random.Generator) -> FloatArray:
    """Positive values in two channels, different in every cell."""
    return rng.uniform(1.0, 2.0, (*GRID.shape, 2))


def test_a_table_at_its_nodes_is_its_values(values: FloatArray) -> None:
    theta_h, theta_d, _ = GRID.half_diff(GRID.cells)
    inside = GRID.cells[(theta_h > 0) & (theta_d > 0)]
    found = Table(values, GRID).evaluate(*GRID.directions(inside))
    np.testing.assert_allclose(found, values.reshape(-1, 2)[inside], rtol=1e-6)


def test_a_constant_table_is_constant_above_and_zero_below(random_directions: Pairs) -> None:
    table = Table(np.full((*GRID.shape, 3), 0.25), GRID)
    wi, wo = random_directions(200)
    np.testing.assert_allclose(table.evaluate(wi, wo), 0.25)
    under = wo * np.array([1.0, 1.0, -1.0])
    assert (table.evaluate(wi, under) == 0.0).all()
    assert (table.evaluate(under, wi) == 0.0).all()


def test_a_table_is_reciprocal(values: FloatArray, random_directions: Pairs) -> None:
    table, (wi, wo) = Table(values, GRID), random_directions(200)
    np.testing.assert_allclose(table.evaluate(wi, wo), table.evaluate(wo, wi), rtol=1e-9)


def test_a_table_does_not_change_when_the_sample_turns(
    values: FloatArray, random_directions: Pairs
) -> None:
    table, (wi, wo) = Table(values, GRID), random_directions(200)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(
        table.evaluate(wi @ turn, wo @ turn), table.evaluate(wi, wo), rtol=1e-9
    )


def test_an_interpolated_value_lies_between_its_neighbours(
    values: FloatArray, random_directions: Pairs
) -> None:
    found = Table(values, GRID).evaluate(*random_directions(500))
    assert (found >= 1.0).all()
    assert (found <= 2.0).all()


def test_cells_below_the_horizon_are_never_valid(values: FloatArray) -> None:
    table = Table(values, GRID, valid=np.ones(GRID.shape, bool))
    assert np.array_equal(table.mask, GRID.above_horizon)
    assert table.missing == 0


def test_a_cell_with_a_channel_that_is_not_finite_is_not_valid(values: FloatArray) -> None:
    values[2, 1, 3, 1] = np.nan
    values[2, 1, 4, 0] = np.inf
    table = Table(values, GRID)
    assert table.missing == 2
    assert not table.mask[2, 1, 3:5].any()


def test_values_of_invalid_cells_are_never_used(
    values: FloatArray, rng: np.random.Generator, random_directions: Pairs
) -> None:
    hidden = rng.uniform(size=GRID.shape) < 0.4
    values[hidden] = 1e30
    marked = Table(values, GRID, valid=~hidden)
    assert marked.missing == np.count_nonzero(hidden & GRID.above_horizon)
    pairs = random_directions(500)
    found = marked.evaluate(*pairs)
    assert (found <= 2.0).all()
    values[hidden] = np.nan
    np.testing.assert_array_equal(Table(values, GRID).evaluate(*pairs), found)


def test_a_hole_is_answered_by_its_nearest_valid_cell(values: FloatArray) -> None:
    valid = np.zeros(GRID.shape, bool)
    valid[1, 1, 2] = valid[5, 1, 2] = True
    table = Table(values, GRID, valid=valid)
    wi, wo = GRID.directions(np.ravel_multi_index(([2, 5], [1, 1], [2, 2]), GRID.shape))
    np.testing.assert_allclose(table.evaluate(wi, wo), values[[1, 5], 1, 2])


def test_the_nearest_valid_cell_may_lie_across_the_seam_of_phi_d(values: FloatArray) -> None:
    valid = np.zeros(GRID.shape, bool)
    valid[2, 1, 7] = valid[2, 1, 4] = True
    wi, wo = GRID.directions(np.ravel_multi_index(([2], [1], [1]), GRID.shape))
    found = Table(values, GRID, valid=valid).evaluate(wi, wo)
    np.testing.assert_allclose(found, values[None, 2, 1, 7])


def test_a_table_of_holes_only_gives_nan(values: FloatArray, random_directions: Pairs) -> None:
    wi, wo = random_directions(5)
    table = Table(values, GRID, valid=np.zeros(GRID.shape, bool))
    assert np.isnan(table.evaluate(wi, wo)).all()
    assert (table.evaluate(wi, -wo) == 0.0).all()


def test_a_direction_that_is_not_finite_gives_nan(values: FloatArray) -> None:
    wi = np.array([[np.nan, 0.0, 1.0], [0.0, 0.0, 1.0]])
    wo = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    assert np.isnan(Table(values, GRID).evaluate(wi, wo)).tolist() == [[True] * 2, [False] * 2]


def test_a_vector_that_is_not_unit_is_named(values: FloatArray) -> None:
    wi = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 57.3]])
    with pytest.raises(UsageError, match=r"wi: found a vector of length 57.3 in row 1 \(1 such"):
        Table(values, GRID).evaluate(wi, wi)


def test_a_table_is_continuous_through_a_mirror_pair(values: FloatArray) -> None:
    # along theta_h through 0 phi_d jumps; a table that does not depend on phi_d there does not
    values[:2] = values[:2, :, :1]
    table = Table(values, GRID)
    tiny = 1e-9
    at = [
        table.evaluate(*directions_from_half_diff(np.array([theta_h]), 0.5, 1.0))
        for theta_h in (0.0, tiny)
    ]
    # theta_h is warped by a square root: 1e-9 rad is 2e-4 of a node spacing
    np.testing.assert_allclose(at[0], at[1], atol=1e-3)


def test_the_arrays_cannot_be_written_and_do_not_change_with_their_source(
    values: FloatArray,
) -> None:
    table = Table(values, GRID)
    values[:] = 0.0
    assert (table.values >= 1.0).all()
    for array in (table.values, table.mask):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0, 0] = 0


def test_an_array_handed_over_read_only_is_not_copied(values: FloatArray) -> None:
    values.flags.writeable = False
    assert Table(values, GRID).values is values


def test_one_channel_may_come_without_its_axis(values: FloatArray) -> None:
    table = Table(values[..., 0], GRID)
    assert table.n_channels == 1
    assert table.channels == ("value",)


def test_whole_numbers_become_floats() -> None:
    assert Table(np.ones(GRID.shape, int), GRID).values.dtype == np.float64


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"values": np.zeros((6, 7, 8, 2))}, r"values of shape \(6, 7, 8, 2\) but the grid wants"),
        ({"valid": np.ones((7, 6), bool)}, r"valid mask of shape \(7, 6\) but the grid wants"),
        ({"channels": ("R", "G", "B")}, r"found 3 channel names .* but 2 channels"),
        ({"wavelengths": [1.0, 2.0, 3.0]}, r"wavelengths of shape \(3,\) but 2 channels"),
    ],
)
def test_shapes_that_disagree_are_named(
    values: FloatArray, arguments: dict[str, object], message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        Table(**{"values": values, "grid": GRID, **arguments})  # type: ignore[arg-type]


def test_values_known_to_be_finite_are_not_asked_and_those_of_the_next_table_are() -> None:
    grid = Grid(4, 4, 4)
    values = np.full((*grid.shape, 2), np.nan)
    trusted = Table(values=values, grid=grid, known_finite=True)
    assert np.array_equal(trusted.mask, grid.above_horizon)
    assert not Table(values=values, grid=grid).mask.any()
    assert not replace(trusted, valid=None).mask.any()


def test_the_mask_of_a_table_cannot_be_written_to() -> None:
    grid = Grid(4, 4, 4)
    for given in (None, np.ones(grid.shape, dtype=bool)):
        table = Table(values=np.ones((*grid.shape, 1)), grid=grid, valid=given)
        assert not table.mask.flags.writeable
    assert given.flags.writeable
