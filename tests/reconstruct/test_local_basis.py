"""Local splines: what their space holds is reproduced, and phi_d is a circle."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.geometry import directions_from_half_diff
from brdfit.grid import Grid
from brdfit.progress import silent
from brdfit.reconstruct import LocalBasis
from brdfit.reconstruct.local_basis import SplineSpace
from brdfit.samples import Samples

SPACE = SplineSpace((8, 6, 6))
SMOOTHLY = LocalBasis(n_theta_h=8, n_theta_d=6, n_phi_d=6, smoothing=1e-9)


@pytest.fixture
def points(rng):
    """Return 4000 triples, poles, edges and knots among them."""
    theta_h = rng.uniform(0.0, np.pi / 2, 4000)
    theta_d = rng.uniform(0.0, np.pi / 2, 4000)
    phi_d = rng.uniform(0.0, 2.0 * np.pi, 4000)
    theta_h[:4] = [0.0, np.pi / 2, 0.3, 0.3]
    theta_d[:4] = [0.2, 0.2, 0.0, np.pi / 2]
    phi_d[4:9] = [0.0, np.pi, np.nextafter(np.pi, 0.0), np.pi / 6, 2.0 * np.pi]
    return theta_h, theta_d, phi_d


def test_the_splines_are_a_partition_of_one(points):
    design = SPACE.design(*points)
    assert design.shape == (4000, SPACE.size) == (4000, 8 * 6 * 6)
    assert np.allclose(design.sum(axis=1), 1.0)
    assert design.data.min() >= 0.0
    assert np.diff(design.indptr).max() <= 4**3  # local: few are above zero anywhere


def test_phi_d_is_a_circle_of_half_a_turn(points):
    theta_h, theta_d, phi_d = points
    design = SPACE.design(theta_h, theta_d, phi_d).toarray()
    turned = SPACE.design(theta_h, theta_d, phi_d + np.pi).toarray()
    assert np.abs(design - turned).max() < 1e-9
    seam = np.array([np.pi - 1e-9, 1e-9])
    left, right = SPACE.design(np.full(2, 0.3), np.full(2, 0.4), seam).toarray()
    assert np.abs(left - right).max() < 1e-7


def test_constants_cost_no_roughness_and_all_else_does(rng):
    penalty = SPACE.penalty()
    assert np.allclose(penalty, penalty.T)
    assert np.abs(penalty @ np.ones(SPACE.size)).max() < 1e-12
    q = rng.normal(size=SPACE.size)
    assert q @ penalty @ q > 0.0
    # the mean square second difference, spelled out along each axis
    cube = q.reshape(SPACE.shape)
    around = np.concatenate([cube[..., -1:], cube, cube[..., :1]], axis=2)
    rough = [np.diff(cube, 2, axis=0), np.diff(cube, 2, axis=1), np.diff(around, 2, axis=2)]
    assert q @ penalty @ q == pytest.approx(sum((d**2).sum() for d in rough) / SPACE.size)


def dense_samples(n=6000):
    rng = np.random.default_rng(2)
    angles = np.stack(
        [
            (rng.random(n) ** 2) * np.pi / 2,
            rng.random(n) * np.pi / 2,
            rng.random(n) * 2.0 * np.pi,
        ]
    )
    wi, wo = directions_from_half_diff(*angles)
    above = (wi[:, 2] > 0.05) & (wo[:, 2] > 0.05)
    return wi[above], wo[above], angles[:, above]


@pytest.mark.parametrize("metric", ["linear", "root", "log"])
def test_functions_of_its_own_space_are_reproduced(metric):
    wi, wo, angles = dense_samples()
    smooth = np.cos(np.linspace(0.0, 2.0, SPACE.size)) * 0.3 + 1.0
    encoded = SPACE.design(*angles) @ smooth
    value = {"linear": encoded, "root": encoded**2, "log": np.exp(encoded)}[metric]
    method = LocalBasis(error_metric=metric, n_theta_h=8, n_theta_d=6, n_phi_d=6, smoothing=1e-9)
    samples = Samples(wi=wi, wo=wo, value=value)
    half = np.arange(len(samples)) % 2 == 0
    result = method.fit(samples.subset(half))
    found = result.evaluate(wi[~half], wo[~half])[:, 0]
    assert np.abs(np.log(found / value[~half])).max() < 0.01


def test_more_smoothing_makes_a_smoother_spline(measure):
    rough = []
    for smoothing in (1e-4, 1e-1, 1e3):
        model = (
            LocalBasis(smoothing=smoothing, n_theta_h=8, n_theta_d=6, n_phi_d=6)
            .fit(measure())
            .model
        )
        q = model.coefficients[:, 0]
        rough.append(q @ SPACE.penalty() @ q)
    assert rough == sorted(rough, reverse=True)


def test_at_a_pole_the_table_does_not_depend_on_phi_d(measure):
    grid = Grid(9, 8, 12)
    values = SMOOTHLY.fit(measure(n=300)).table(grid).values
    assert np.ptp(values[0, :-1], axis=1).max() < 1e-5 * values[0].max()
    assert np.ptp(values[1:-1, 0], axis=1).max() < 1e-5 * values[:, 0].max()


def test_fitting_with_a_prepared_solver_is_fitting(measure):
    samples = measure(n=200)
    design = SMOOTHLY.space.design(*samples.half_diff)
    prepared = SMOOTHLY.fit_solved(SMOOTHLY.solver(design), np.log(samples.value))
    model = SMOOTHLY.fit(samples).model
    assert np.allclose(prepared.coefficients, model.coefficients, atol=1e-6)
    grid = Grid(5, 5, 6)
    assert np.allclose(prepared.dense(grid, silent), model.dense(grid, silent), rtol=1e-4)
