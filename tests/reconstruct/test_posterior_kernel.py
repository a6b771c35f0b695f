"""The kernel of the local residual, and the sum over samples that it becomes on a grid."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.grid import Grid
from brdfit.reconstruct.posterior.kernel import Kernel


@pytest.fixture
def angles():
    rng = np.random.default_rng(3)
    return rng.uniform(0, 1.5, 40), rng.uniform(0, 1.5, 40), rng.uniform(-3, 3, 40)


def test_it_is_a_covariance_of_the_stated_amplitude(angles):
    gram = Kernel(0.4, 3.0, 0.3).between(angles, angles)
    assert np.allclose(gram, gram.T)
    assert np.allclose(np.diagonal(gram), 0.09)
    assert np.linalg.eigvalsh(gram).min() > -1e-10


def test_it_is_the_formula_of_matern():
    one = tuple(np.array([x]) for x in (0.0, 0.0, 0.0))
    other = tuple(np.array([x]) for x in (0.0, np.pi / 2 * 0.3, 0.0))
    d = np.sqrt(3.0) * 0.3 / 0.5
    assert np.isclose(Kernel(0.5, 1.0, 2.0).between(one, other), 4.0 * (1 + d) * np.exp(-d))


def test_reciprocal_pairs_are_one_and_azimuth_has_no_say_at_the_poles(angles):
    kernel = Kernel(0.4, 1.0, 1.0)
    theta_h, theta_d, phi_d = angles
    plain = kernel.between(angles, angles)
    assert np.allclose(kernel.between((theta_h, theta_d, phi_d + np.pi), angles), plain)
    for pole in ((0 * theta_h, theta_d, phi_d), (theta_h, 0 * theta_d, phi_d)):
        turned = (*pole[:2], phi_d + 0.7)
        assert np.allclose(kernel.between(pole, angles), kernel.between(turned, angles))


@pytest.mark.parametrize("shape", [(90, 90, 180), (12, 9, 10), (3, 2, 2)])
def test_on_a_grid_it_is_the_sum_over_the_centres(angles, shape):
    grid, kernel = Grid(*shape), Kernel(0.4, 1.0, 0.3)
    alpha = np.random.default_rng(4).normal(size=(40, 2))
    dense = kernel.on_grid(grid, angles, alpha).reshape(-1, 2)
    cells = np.random.default_rng(5).choice(grid.size, min(grid.size, 2000), replace=False)
    exact = kernel.between(grid.half_diff(cells), angles) @ alpha
    assert np.abs(dense[cells] - exact).max() < 0.005 * np.abs(exact).max()
