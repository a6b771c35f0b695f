"""Laws of the grid: nodes, positions, interpolation, the horizon, solid angles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical, half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid

QUARTER, HALF = np.pi / 2, np.pi

sizes = st.builds(Grid, st.integers(2, 9), st.integers(2, 9), st.integers(2, 9))
points = st.tuples(
    st.floats(0.0, QUARTER), st.floats(0.0, QUARTER), st.floats(-7.0, 7.0, allow_subnormal=False)
)


def interpolated(grid: Grid, values: FloatArray, angles: tuple[FloatArray, ...]) -> FloatArray:
    index, weight = grid.corners(*angles)
    return np.asarray((values.ravel()[index] * weight).sum(axis=1))


@given(sizes)
def test_a_node_is_nearest_to_itself(grid: Grid) -> None:
    flat = np.arange(grid.size)
    assert np.array_equal(grid.nearest(*grid.half_diff(flat)), flat)


@given(sizes)
def test_position_inverts_the_node_formulas(grid: Grid) -> None:
    flat = np.arange(grid.size)
    position = grid.position(*grid.half_diff(flat))
    np.testing.assert_allclose(position, np.unravel_index(flat, grid.shape), atol=1e-9)


@given(sizes)
def test_a_node_comes_back_through_its_directions(grid: Grid) -> None:
    cells = grid.cells
    theta_h, theta_d, _ = grid.half_diff(cells)
    inside = cells[(theta_h > 0) & (theta_d > 0)]
    back = grid.nearest(*half_diff_from_directions(*grid.directions(inside)))
    assert np.array_equal(back, inside)


@given(sizes)
def test_values_are_spread_to_their_cells_and_nothing_is_below_the_horizon(grid: Grid) -> None:
    values = np.arange(1.0, 2 * grid.cells.size + 1).reshape(-1, 2)
    spread = grid.spread(values)
    assert spread.dtype == np.float32
    assert spread.shape == (*grid.shape, 2)
    assert np.array_equal(spread.reshape(-1, 2)[grid.cells], values)
    assert not spread[~grid.above_horizon].any()


@given(sizes, sizes)
def test_interpolation_to_another_grid_is_a_product_of_three_matrices(
    grid: Grid, other: Grid
) -> None:
    values = np.random.default_rng(3).normal(size=grid.shape)
    expected = interpolated(grid, values, other.half_diff(np.arange(other.size)))
    found = np.einsum("ia,jb,kc,abc->ijk", *grid.linear(other), values)
    np.testing.assert_allclose(found.ravel(), expected, atol=1e-9)


@given(sizes, points)
def test_weights_are_a_partition_of_one(grid: Grid, point: tuple[float, float, float]) -> None:
    index, weight = grid.corners(*point)
    assert index.shape == weight.shape == (1, 8)
    assert (weight >= 0.0).all()
    np.testing.assert_allclose(weight.sum(), 1.0, atol=1e-12)
    assert ((index >= 0) & (index < grid.size)).all()


@given(sizes)
def test_interpolation_gives_the_node_values_at_the_nodes(grid: Grid) -> None:
    values = np.random.default_rng(grid.size).uniform(size=grid.shape)
    at_nodes = interpolated(grid, values, grid.half_diff(np.arange(grid.size)))
    np.testing.assert_allclose(at_nodes, values.ravel(), atol=1e-9)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.integers(0, 2**32 - 1))
def test_interpolation_is_exact_for_multilinear_functions_of_the_node_position(
    u: float, v: float, w: float, seed: int
) -> None:
    grid = Grid(7, 5, 6)
    c = np.random.default_rng(seed).normal(size=(2, 2, 2))
    i, j, k = np.indices(grid.shape)

    def multilinear(i: FloatArray, j: FloatArray, k: FloatArray) -> FloatArray:
        powers = np.stack([np.ones_like(i), i]), np.stack([np.ones_like(j), j])
        return np.einsum("abc,a...,b...,c...", c, *powers, np.stack([np.ones_like(k), k]))

    # the last interval of phi_d leads back to node 0, where a linear function has its seam
    at = u * (grid.n_theta_h - 1), v * (grid.n_theta_d - 1), w * (grid.n_phi_d - 1)
    angles = (
        (at[0] / grid.n_theta_h) ** 2 * QUARTER,
        at[1] / grid.n_theta_d * QUARTER,
        at[2] / grid.n_phi_d * HALF,
    )
    values = multilinear(i.astype(float), j.astype(float), k.astype(float))
    expected = multilinear(*(np.array(x) for x in at))
    np.testing.assert_allclose(interpolated(grid, values, angles), expected, atol=1e-7)


@given(st.floats(0.0, QUARTER), st.floats(0.0, QUARTER), st.integers(-3, 3), st.integers(0, 99))
def test_interpolation_is_continuous_across_the_seam_of_phi_d(
    theta_h: float, theta_d: float, turns: int, seed: int
) -> None:
    grid = Grid(4, 5, 6)
    values = np.random.default_rng(seed).uniform(size=grid.shape)
    step = 1e-9
    before, after = (
        interpolated(grid, values, (theta_h, theta_d, turns * HALF + side * step))
        for side in (-1, 1)
    )
    # a slope is at most one unit a node spacing
    np.testing.assert_allclose(before, after, atol=4 * step * grid.n_phi_d / HALF)


@given(points, st.integers(0, 99))
def test_interpolation_is_the_same_half_a_turn_on(
    point: tuple[float, float, float], seed: int
) -> None:
    grid = Grid(4, 5, 6)
    values = np.random.default_rng(seed).uniform(size=grid.shape)
    theta_h, theta_d, phi_d = point
    here = interpolated(grid, values, point)
    there = interpolated(grid, values, (theta_h, theta_d, phi_d + HALF))
    np.testing.assert_allclose(here, there, atol=1e-9)


@given(st.floats(0.0, QUARTER), st.floats(0.0, QUARTER), st.floats(0.0, HALF))
def test_interpolation_stays_within_the_values_around(
    theta_h: float, theta_d: float, phi_d: float
) -> None:
    grid = Grid(4, 5, 6)
    values = np.random.default_rng(5).uniform(2.0, 3.0, size=grid.shape)
    assert 2.0 - 1e-12 <= interpolated(grid, values, (theta_h, theta_d, phi_d))[0] <= 3.0 + 1e-12


def test_beyond_the_last_nodes_the_value_is_constant() -> None:
    grid = Grid(4, 5, 6)
    values = np.random.default_rng(1).uniform(size=grid.shape)
    at_horizon = interpolated(grid, values, (QUARTER, QUARTER, 0.0))
    np.testing.assert_allclose(at_horizon, values[-1, -1, 0])


def test_the_flat_index_is_that_of_the_merl_format() -> None:
    # index = phi_d + 180 (theta_d + 90 theta_h), after Matusik et al. 2003
    theta_h, theta_d, phi_d = MERL_GRID.half_diff(np.array([7 + 180 * (5 + 90 * 3)]))
    np.testing.assert_allclose(np.degrees(theta_h), 9.0 / 8100.0 * 90.0)
    np.testing.assert_allclose(np.degrees(theta_d), 5.0)
    np.testing.assert_allclose(np.degrees(phi_d), 7.0)


def test_1_111_430_nodes_of_the_merl_grid_are_above_the_horizon() -> None:
    assert MERL_GRID.size == 1_458_000
    assert np.count_nonzero(MERL_GRID.above_horizon) == MERL_GRID.cells.size == 1_111_430


@given(sizes)
def test_a_cell_exists_where_both_directions_of_its_node_are_above_the_horizon(
    grid: Grid,
) -> None:
    wi, wo = grid.directions(np.arange(grid.size))
    above = (wi[:, 2] > 1e-9) & (wo[:, 2] > 1e-9)
    assert np.array_equal(grid.above_horizon.ravel(), above)
    assert np.array_equal(grid.cells, np.flatnonzero(above))


@given(sizes)
def test_solid_angles_sum_to_one_and_are_zero_below_the_horizon(grid: Grid) -> None:
    np.testing.assert_allclose(grid.solid_angle.sum(), 1.0)
    assert np.array_equal(grid.solid_angle > 0.0, grid.above_horizon)


def test_solid_angles_agree_with_uniformly_drawn_pairs(rng: np.random.Generator) -> None:
    grid, n = Grid(30, 30, 36), 1_000_000
    cosines, phi = rng.uniform(0, 1, (2, n)), rng.uniform(-HALF, HALF, (2, n))
    wi, wo = directions_from_spherical(np.arccos(cosines), phi)
    drawn = np.bincount(grid.nearest(*half_diff_from_directions(wi, wo)), minlength=grid.size) / n

    def blocks(measure: FloatArray) -> FloatArray:
        return np.asarray(measure.reshape(6, 5, 6, 5, 4, 9).sum(axis=(1, 3, 5)))

    # only where no cell is cut by the horizon: there the rule takes a cell whole or not at all
    whole = grid.above_horizon.reshape(6, 5, 6, 5, 4, 9).all(axis=(1, 3, 5))
    whole[:, -1] = whole[-1] = False
    expected, found = blocks(grid.solid_angle)[whole], blocks(drawn)[whole]
    big = expected > 2e-3
    assert big.sum() >= 20
    # one number of their own: how much of the measure the rule at the horizon takes or leaves
    found = found * (expected[big].sum() / found[big].sum())
    np.testing.assert_allclose(found[big], expected[big], rtol=0.08)


@pytest.mark.parametrize("sizes", [(1, 5, 5), (5, 0, 5), (5, 5, -2)])
def test_a_grid_too_small_is_named(sizes: tuple[int, int, int]) -> None:
    with pytest.raises(UsageError, match=r"Grid: n_\w+ is .* needs at least 2 nodes"):
        Grid(*sizes)


def test_equal_sizes_make_equal_grids() -> None:
    assert Grid() == MERL_GRID
    assert hash(Grid(3, 4, 5)) == hash(Grid(3, 4, 5))
    assert Grid(3, 4, 5) != Grid(5, 4, 3)


@pytest.mark.parametrize("name", ["theta_h", "theta_d", "phi_d", "above_horizon", "solid_angle"])
def test_the_arrays_of_a_grid_cannot_be_written(name: str) -> None:
    with pytest.raises(ValueError, match="read-only"):
        getattr(Grid(3, 4, 5), name)[...] = 0
