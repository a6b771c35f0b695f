"""Kriging from neighbours: with all rows it is kriging; a place stands alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from brdfit.linalg import Neighbours


@pytest.fixture
def rows():
    rng = np.random.default_rng(0)
    places, values = rng.random((40, 3)), rng.standard_normal((40, 2))
    return Neighbours.of(places, values, rng.uniform(0.01, 0.1, 40), 0.5, 40)


def kernel(one, other):
    d = np.sqrt(3.0) * np.linalg.norm(one[:, None] - other[None], axis=2) / 0.5
    return (1.0 + d) * np.exp(-d)


def test_with_every_row_a_neighbour_it_is_kriging(rows):
    at = np.random.default_rng(1).random((7, 3))
    cross = kernel(at, rows.places)
    weights = np.linalg.solve(kernel(rows.places, rows.places) + np.diag(rows.nugget), cross.T).T
    found = rows.at(at)
    assert np.allclose(found.mean, weights @ rows.values)
    assert np.allclose(found.variance, 1.0 - (weights * cross).sum(axis=1))


def test_a_row_that_is_left_out_has_no_say(rows):
    some = replace(rows, count=10)
    own = np.arange(40)
    found = some.at(rows.places, own)
    assert not (found.neighbours == own[:, None]).any()
    spoilt = rows.values.copy()
    spoilt[3] += 1e6
    again = replace(some, values=spoilt).at(rows.places, own)
    assert np.array_equal(again.mean[3], found.mean[3])


def test_every_place_stands_alone(rows):
    at = np.random.default_rng(2).random((700, 3))
    order = np.random.default_rng(3).permutation(700)
    some = replace(rows, count=8)
    assert np.array_equal(some.at(at).mean[order], some.at(at[order]).mean)
    assert np.array_equal(some.at(at[5:6]).mean, some.at(at).mean[5:6])


def test_far_from_every_row_nothing_is_known(rows):
    found = rows.at(np.full((1, 3), 100.0))
    assert np.abs(found.mean).max() < 1e-12
    assert found.variance[0] == pytest.approx(1.0)


def test_fewer_rows_than_neighbours_are_all_of_them():
    places = np.random.default_rng(0).random((3, 2))
    few = Neighbours.of(places, np.ones((3, 1)), np.full(3, 0.1), 0.5, 24)
    assert few.at(places).neighbours.shape == (3, 3)
    assert few.at(places, np.arange(3)).neighbours.shape == (3, 2)
    assert few.at(np.empty((0, 2))).mean.shape == (0, 1)


def test_compiled_or_not_it_is_one_answer(rows):
    pytest.importorskip("numba")
    at = np.random.default_rng(4).random((300, 3))
    twice = Neighbours.of(
        np.concatenate([rows.places, rows.places]),  # rows that coincide
        np.concatenate([rows.values, -rows.values]),
        np.full(80, 1e-4),
        0.5,
        24,
    )
    for system in (rows, replace(rows, count=9), twice):
        index, distance = system._nearest(at, None)
        for one, other in zip(
            system._solved(index, distance), system.plain_solved(index, distance), strict=True
        ):
            assert np.allclose(one, other, rtol=0.0, atol=1e-10)
