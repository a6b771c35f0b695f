"""The smooth residual of `Compact`: what it is on a grid, at a pole, for a reciprocal pair."""

from __future__ import annotations

import numpy as np

from brdfit.grid import Grid
from brdfit.reconstruct.compact.residual import LocalResidual, Scale


def test_the_residual_on_axes_is_the_residual_at_the_nodes():
    residual = LocalResidual.of(Scale(0.2, 0.3, 120))
    z = np.random.default_rng(5).normal(size=(residual.size, 2))
    grid = Grid(5, 4, 6)
    dense = residual.on_axes(z, grid.theta_h, grid.theta_d, grid.phi_d)
    at_nodes = residual.at(grid.half_diff(np.arange(grid.size))) @ z
    assert np.allclose(dense.reshape(-1, 2), at_nodes, atol=1e-4)


def test_the_residual_is_reciprocal_and_knows_no_azimuth_at_the_poles():
    residual = LocalResidual.of(Scale())
    angle = np.array([0.3, 0.7, 1.1])
    one = residual.at((angle, angle, angle))
    assert np.allclose(one, residual.at((angle, angle, angle + np.pi)))
    for pole in ((angle * 0.0, angle, angle), (angle, angle * 0.0, angle)):
        turned = (pole[0], pole[1], angle + 0.5)
        assert np.allclose(residual.at(pole), residual.at(turned), atol=1e-6)
