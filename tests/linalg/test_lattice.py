"""A lattice: through its nodes, closed around, the same by points and by axes."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.linalg import Lattice, node_positions

SHAPE = (9, 8, 6)


@pytest.fixture
def values():
    return np.random.default_rng(0).standard_normal((*SHAPE, 2))


@pytest.fixture
def points():
    return np.random.default_rng(1).random((200, 3))


def test_it_passes_through_its_nodes(values):
    lattice = Lattice.through(values)
    assert lattice.shape == SHAPE
    assert np.allclose(lattice.at(node_positions(SHAPE)), values.reshape(-1, 2), atol=2e-6)


def test_points_and_axes_read_the_same_function(values, points):
    lattice = Lattice.through(values)
    x, y, z = points[:5, 0], points[:7, 1], points[:4, 2] * 3.0
    matrices = lattice.matrices(x, y, z)
    on_axes = np.einsum("ai,bj,ck,ijkq->abcq", *matrices, lattice.coefficients)
    assert on_axes.shape == (5, 7, 4, 2)
    pairs = np.stack([a.ravel() for a in np.meshgrid(x, y, z, indexing="ij")], axis=1)
    assert np.allclose(on_axes.reshape(-1, 2), lattice.at(pairs), atol=5e-6)


def test_the_last_axis_is_closed(values, points):
    lattice = Lattice.through(values)
    around = points + np.array([0.0, 0.0, 1.0])
    assert np.allclose(lattice.at(points), lattice.at(around), atol=1e-5)


def test_a_smooth_function_is_told_between_the_nodes(points):
    def smooth(x):
        return np.stack([np.sin(2.0 * x[:, 0]) * x[:, 1] + np.cos(2.0 * np.pi * x[:, 2])], axis=1)

    shape = (20, 20, 20)
    lattice = Lattice.through(smooth(node_positions(shape)).reshape(*shape, 1))
    inside = points * np.array([0.8, 0.8, 1.0]) + np.array([0.1, 0.1, 0.0])
    assert np.abs(lattice.at(inside) - smooth(inside)).max() < 1e-3


def test_outside_the_box_is_its_edge(values):
    lattice = Lattice.through(values)
    assert np.array_equal(
        lattice.at(np.array([[1.5, -0.2, 0.3]])), lattice.at(np.array([[1.0, 0.0, 0.3]]))
    )
