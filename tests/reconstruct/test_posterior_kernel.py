"""The kernel of the local residual, and the sum over samples that it becomes on a grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from brdfit.grid import MERL_GRID, Grid
from brdfit.reconstruct.posterior.kernel import Kernel
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.nodes import residual_on_grid
from brdfit.reconstruct.posterior.prior import population_prior
from brdfit.reconstruct.posterior.refine import Belief, Explanation
from brdfit.reconstruct.posterior.search import Design, Search
from brdfit.reconstruct.posterior.section import SECTION, Section
from brdfit.reconstruct.posterior.stages import _section
from brdfit.robust import Background, Mixture


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


def on_grid(kernel, grid, centres, alpha):
    """Return the sum at all cells (size, c)."""
    carried = residual_on_grid(kernel, grid, centres, alpha)
    dense = np.zeros((*grid.shape, alpha.shape[1]), dtype=np.float32)
    for i, logs in enumerate(dense):
        logs[:] = carried.at(i).transpose(1, 2, 0)
    return dense.reshape(grid.size, -1)


def few_of(grid, seed):
    return np.random.default_rng(seed).choice(grid.cells, min(grid.cells.size, 2000), replace=False)


@pytest.mark.parametrize("channels", [2, 6])
@pytest.mark.parametrize("shape", [(12, 9, 10), (3, 2, 2)])
def test_where_nodes_are_the_cells_the_sum_is_exact(angles, shape, channels):
    grid, kernel = Grid(*shape), Kernel(0.15, 1.0, 0.3)
    alpha = np.random.default_rng(4).normal(size=(40, channels))
    cells = few_of(grid, 5)
    exact = kernel.between(grid.half_diff(cells), angles) @ alpha
    assert np.abs(on_grid(kernel, grid, angles, alpha)[cells] - exact).max() < 1e-5


@pytest.mark.parametrize("grazing", [0.0, Search().grazing])
@pytest.mark.parametrize(("length", "stretch"), Search().shapes)
def test_what_follows_samples_is_carried_to_the_cells_within_two_thousandths(
    length, stretch, grazing
):
    kernel, rng = Kernel(length, stretch, 0.1, grazing), np.random.default_rng(6)
    centres = MERL_GRID.half_diff(rng.choice(MERL_GRID.cells, 500, replace=False))
    gram = kernel.between(centres, centres)
    drawn = np.linalg.cholesky(gram + 1e-9 * np.eye(500)) @ rng.normal(size=(500, 3))
    noise = 0.02
    measured = drawn + noise * rng.normal(size=drawn.shape)
    alpha = np.linalg.solve(gram + noise**2 * np.eye(500), measured)
    cells = few_of(MERL_GRID, 7)
    exact = kernel.between(MERL_GRID.half_diff(cells), centres) @ alpha
    off = np.abs(on_grid(kernel, MERL_GRID, centres, alpha)[cells] - exact)
    assert np.ptp(exact) > 0.1
    assert off.max() < 2e-3


def test_the_horizon_is_further_away_where_it_counts_and_nothing_else_is(angles):
    theta_h, theta_d = np.radians([[5.0, 5.0], [10.0, 80.0]])
    zero = np.zeros(2)
    normal, grazing = (theta_h[:1], theta_d[:1], zero[:1]), (theta_h[1:], theta_d[1:], zero[1:])
    plain, far = Kernel(1.0, 1.0, 1.0), Kernel(1.0, 1.0, 1.0, 0.25)
    assert far.between(normal, grazing) < 0.8 * plain.between(normal, grazing)
    high = tuple(angle[np.cos(angles[0]) * np.cos(angles[1]) > 0.9] for angle in angles)
    np.testing.assert_allclose(far.between(high, high), plain.between(high, high), atol=0.02)


def test_the_distance_to_the_horizon_is_reciprocal_and_finite_below_it():
    theta_h, theta_d, phi_d = (np.radians([60.0, 85.0]), np.radians([50.0, 85.0]), np.zeros(2))
    kernel = Kernel(0.4, 1.0, 1.0, 0.25)
    there = kernel.coordinates((theta_h, theta_d, phi_d))
    assert np.isfinite(there).all()
    other = kernel.coordinates((theta_h, theta_d, phi_d + np.pi))
    np.testing.assert_allclose(there, other, atol=1e-12)


PEAK = Section(
    np.log(0.05 + 20.0 * np.exp(-((SECTION.theta_h[:, None] / 0.15) ** 2)))
    + 0.5 * SECTION.theta_d**4
)


def test_on_the_flank_of_a_lobe_neighbours_are_further_apart_and_elsewhere_they_are_not():
    plain, following = Kernel(1.0, 1.0, 1.0), Kernel(1.0, 1.0, 1.0, lobe=0.5, section=PEAK)

    def between(kernel, one, other):
        (a, b), zero = np.radians([[one], [other]]), np.zeros(1)
        return kernel.between((a, zero, zero), (b, zero, zero)).item()

    assert between(following, 8.0, 14.0) < 0.8 * between(plain, 8.0, 14.0)
    assert between(following, 50.0, 60.0) == pytest.approx(between(plain, 50.0, 60.0), abs=1e-3)


def test_one_that_follows_a_lobe_is_a_covariance_too_and_reciprocal(angles):
    kernel = Kernel(0.4, 3.0, 0.3, 0.25, 0.5, PEAK)
    gram = kernel.between(angles, angles)
    assert np.allclose(np.diagonal(gram), 0.09)
    assert np.linalg.eigvalsh(gram).min() > -1e-10
    theta_h, theta_d, phi_d = angles
    assert np.allclose(kernel.between((theta_h, theta_d, phi_d + np.pi), angles), gram)


def test_what_is_known_of_a_lobe_changes_nothing_where_it_does_not_count(angles):
    kernel = Kernel(0.4, 3.0, 0.3, 0.25)
    knowing = replace(kernel, section=PEAK)
    assert np.array_equal(knowing.between(angles, angles), kernel.between(angles, angles))
    alpha = np.ones((len(angles[0]), 1))
    one, other = (on_grid(k, MERL_GRID, angles, alpha) for k in (kernel, knowing))
    assert np.array_equal(one, other)


@pytest.mark.parametrize(("length", "stretch"), Search().following)
def test_what_follows_a_lobe_is_carried_to_the_cells_within_a_hundredth_of_its_size(
    length, stretch
):
    kernel, rng = Kernel(length, stretch, 0.3, 0.0, Search().lobe, PEAK), np.random.default_rng(6)
    centres = MERL_GRID.half_diff(rng.choice(MERL_GRID.cells, 500, replace=False))
    gram = kernel.between(centres, centres)
    drawn = np.linalg.cholesky(gram + 1e-9 * np.eye(500)) @ rng.normal(size=(500, 3))
    alpha = np.linalg.solve(gram + 0.02**2 * np.eye(500), drawn)
    cells = few_of(MERL_GRID, 7)
    exact = kernel.between(MERL_GRID.half_diff(cells), centres) @ alpha
    off = np.abs(on_grid(kernel, MERL_GRID, centres, alpha)[cells] - exact)
    assert np.quantile(off, 0.99) < 0.01 * np.ptp(exact)
    assert off.max() < 0.03 * np.ptp(exact)


def test_a_section_is_its_nodes_and_its_slopes_are_its_own():
    theta_h, theta_d = np.meshgrid(SECTION.theta_h, SECTION.theta_d, indexing="ij")
    found = PEAK.at(theta_h.ravel(), theta_d.ravel()).reshape(PEAK.level.shape)
    np.testing.assert_allclose(found, PEAK.level, atol=1e-9)
    places, slope = PEAK.steepest(1)
    np.testing.assert_allclose(slope, 2.0 * places**3, atol=2e-2)


@pytest.mark.parametrize(("share", "expected"), [(0.05, False), (0.5, True)])
def test_a_first_stage_that_believes_hardly_anybody_knows_of_no_lobe(share, expected):
    rows, axes = 40, np.eye(4, 2)
    rng = np.random.default_rng(8)
    design = Design(
        components=rng.normal(size=(rows, 3)),
        axes=axes,
        weights=np.full(4, 0.25),
        angles=(np.zeros(rows),) * 3,
        section=rng.normal(size=(*SECTION.shape[:2], 3)),
    )
    truth = np.array([1.0, 0.4, -0.3])
    data = measured((design.components @ truth + 0.5)[:, None])
    mixture = Mixture(0.05, Background.of(data.y, data.known))
    belief = Belief(np.full(rows, share), 0.1, mixture, np.ones(rows))
    first = Explanation(
        np.zeros((3, 1)), None, None, None, belief, score=0.0, surprise=None, steps=0, settled=True
    )
    prior = population_prior(axes, np.full(4, 0.25))
    section = _section(data, design, prior, first, Search())
    assert (section is not None) is expected
    if section is not None:
        np.testing.assert_allclose(section.level, design.section @ truth + 0.5, atol=0.02)


def measured(y):
    rows = np.arange(len(y))
    known = np.ones(y.shape, dtype=bool)
    return Measurements(rows, rows, y, known, ~known, np.zeros(len(y)), np.zeros((len(y), 2)))
