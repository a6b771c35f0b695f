"""Members at directions, and which of their channels a channel of samples leans on."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.grid import Grid
from brdfit.populations import VALUE_FLOOR
from brdfit.progress import silent
from brdfit.reconstruct.members import MemberRows, channel_roles, on_grid
from brdfit.samples import Samples


@pytest.fixture
def samples(measure):
    """Return a function that makes two samples with these channels."""

    def make(n, channels=(), wavelengths=None):
        two = measure(n=2)
        return Samples(
            wi=two.wi,
            wo=two.wo,
            value=np.ones((2, n)),
            channels=channels,
            wavelengths=wavelengths,
        )

    return make


def test_members_are_logarithms_held_above_the_floor(toy, random_directions):
    wi, wo = random_directions(50)
    wi[0, 2] = -wi[0, 2]  # below the horizon a member is zero
    rows = MemberRows.at(toy, wi, wo)
    assert (len(rows), rows.members, len(rows.logs)) == (50, len(toy), 3)
    values = np.maximum(toy.evaluate(wi, wo), VALUE_FLOOR)
    for channel, log in enumerate(rows.logs):
        assert log.dtype == np.float32
        assert log.flags.c_contiguous
        assert np.allclose(log, np.log(values[:, :, channel]), atol=1e-6)


def test_many_directions_are_asked_piece_by_piece_and_every_one_answers_for_itself(
    toy, random_directions
):
    wi, wo = random_directions(1300)
    rows = MemberRows.at(toy, wi, wo)
    some = np.array([0, 511, 512, 1023, 1024, 1299])
    few = MemberRows.at(toy, wi[some], wo[some])
    for all_of_them, alone in zip(rows.logs, few.logs, strict=True):
        assert np.allclose(all_of_them[some], alone, atol=1e-6)


def test_taking_rows_and_leaving_members_out(toy, random_directions):
    rows = MemberRows.at(toy, *random_directions(20))
    some = rows.take(slice(5, 9)).without(np.array([0, 2]))
    assert len(some) == 4
    assert some.members == len(toy) - 2
    assert np.array_equal(some.logs[1][:, 0], rows.logs[1][5:9, 1])


def test_channels_of_the_same_name_pair_up_in_any_order(toy, samples):
    assert channel_roles(samples(3), toy).tolist() == [0, 1, 2]
    assert channel_roles(samples(3, ("B", "R", "G")), toy).tolist() == [2, 0, 1]
    assert channel_roles(samples(1, ("B",)), toy).tolist() == [2]


def test_bands_lean_on_the_nearest_primary(toy, samples):
    bands = np.array([400.0, 480.0, 500.0, 560.0, 600.0, 700.0])
    assert channel_roles(samples(6, wavelengths=bands), toy).tolist() == [2, 2, 1, 1, 0, 0]


def test_channels_that_say_nothing_lean_on_green(toy, samples):
    assert channel_roles(samples(1), toy).tolist() == [1]
    assert channel_roles(samples(3, ("x", "y", "z")), toy).tolist() == [0, 1, 2]
    assert channel_roles(samples(5), toy).tolist() == [1] * 5


def test_the_dense_result_is_what_is_found_cell_by_cell(toy):
    grid = Grid(6, 5, 8)

    def first_two(rows):
        return rows.logs[0][:, :2]

    dense = on_grid(toy, grid, first_two, silent)
    direct = first_two(MemberRows.at(toy, *grid.directions(grid.cells)))
    assert dense.shape == (grid.cells.size, 2)
    assert np.allclose(dense, direct, atol=1e-4)
