"""Detail: what many samples say is reproduced; what they do not agree on, or are few of, is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from brdfit.grid import Grid
from brdfit.progress import silent
from brdfit.reconstruct import Posterior
from brdfit.reconstruct.posterior import detail as module
from brdfit.reconstruct.posterior.detail import FEWEST, add_detail
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.refine import Belief
from brdfit.reconstruct.posterior.section import SECTION, Section
from brdfit.reconstruct.posterior.stages import FREEDOM, Judged
from brdfit.robust import Background, Mixture

COUNT = 3300
NOISE = 0.01


def angles_of(count, seed=0):
    u, v, turn = np.random.default_rng(seed).random((3, count))
    return u**2 * np.pi / 2, v * np.pi / 2, turn * np.pi


def peak(angles):
    """A ridge that is narrower than any smooth residual, in two channels."""
    theta_h, theta_d, _ = angles
    height = np.exp(-(((np.sqrt(theta_h) - 0.6) / 0.15) ** 2)) * theta_d
    return np.stack([height, 0.8 * height], axis=1)


def noise(count, seed=1):
    return NOISE * np.random.default_rng(seed).standard_normal((count, 1))


def measured(y):
    rows = np.arange(len(y))
    known = np.ones(y.shape, dtype=bool)
    places = np.zeros((len(y), 1))
    return Measurements(rows, rows, y, known, ~known, np.zeros(len(y)), places)


def fitted(y, angles, mean=None, width=0.1, section=None):
    data = measured(y)
    mixture = Mixture(0.05, Background.of(data.y, data.known), freedom=FREEDOM)
    belief = Belief(np.ones(len(y)), width, mixture, np.ones(len(y)))
    mean = np.zeros_like(y) if mean is None else mean
    return add_detail(data, Judged(np.zeros(len(y)), mean), angles, belief, section)


@pytest.fixture(scope="module")
def angles():
    return angles_of(COUNT)


@pytest.fixture(scope="module")
def of_peak(angles):
    detail, judged = fitted(peak(angles) + noise(COUNT), angles)
    assert detail is not None
    return detail, judged


def test_many_samples_of_a_peak_that_no_stage_knows_are_reproduced(of_peak):
    detail, judged = of_peak
    elsewhere = angles_of(500, seed=9)
    error = np.abs(detail.at(elsewhere) - peak(elsewhere)).mean()
    assert error < 0.1 * np.abs(peak(elsewhere)).mean()
    assert (judged.responsibility < 0.5).mean() < 0.02


def test_a_flank_that_the_population_knows_is_followed(angles):
    def flank(theta_h, theta_d):
        return 3.0 * np.tanh((np.sqrt(theta_h) - 0.4) / 0.01) + 0.0 * theta_d

    section = Section(flank(SECTION.theta_h[:, None], SECTION.theta_d))
    y = np.repeat(0.2 * flank(*angles[:2])[:, None], 2, axis=1) + noise(COUNT)
    elsewhere = angles_of(500, seed=9)
    truth = 0.2 * flank(*elsewhere[:2])[:, None]
    knowing, plain = (
        np.abs(fitted(y, angles, section=one)[0].at(elsewhere) - truth).mean()
        for one in (section, None)
    )
    assert knowing < 0.9 * plain


def test_a_far_outlier_moves_nothing(angles, of_peak):
    one_more = tuple(np.append(axis, axis[7] + 1e-3) for axis in angles)
    y = np.vstack([peak(angles) + noise(COUNT), peak(angles)[7:8] + 4.0])
    detail, judged = fitted(y, one_more)
    elsewhere = angles_of(500, seed=9)
    moved = np.abs(detail.at(elsewhere) - of_peak[0].at(elsewhere))
    assert moved.max() < NOISE
    assert judged.responsibility[-1] < 0.01


def test_outliers_that_are_many_are_named_and_move_little(angles):
    wrong = np.random.default_rng(4).random(COUNT) < 0.4
    factor = np.random.default_rng(5).uniform(-2.3, 2.3, (COUNT, 1))
    y = peak(angles) + noise(COUNT) + wrong[:, None] * factor
    detail, judged = fitted(y, angles)
    far = wrong & (np.abs(factor[:, 0]) > 0.3)
    assert (judged.responsibility[far] < 0.5).mean() > 0.95
    assert (judged.responsibility[~wrong] < 0.5).mean() < 0.05
    elsewhere = angles_of(500, seed=9)
    assert np.median(np.abs(detail.at(elsewhere) - peak(elsewhere))) < 2.0 * NOISE


def test_noise_has_no_detail(angles):
    y = np.repeat(noise(COUNT), 2, axis=1)
    detail, _ = fitted(y, angles, width=NOISE)
    elsewhere = angles_of(500, seed=9)
    assert detail is None or np.abs(detail.at(elsewhere)).mean() < 0.2 * NOISE


def test_few_samples_have_none(angles):
    some = tuple(axis[: FEWEST - 1] for axis in angles)
    y = peak(some)
    detail, judged = fitted(y, some)
    assert detail is None
    assert np.array_equal(judged.responsibility, np.zeros(len(y)))


def test_half_a_row_says_nothing(angles):
    data = measured(peak(angles))
    known = data.known.copy()
    known[: COUNT // 2, 1] = False
    belief = Belief(
        np.ones(COUNT), 0.1, Mixture(0.05, Background.of(data.y, known)), np.ones(COUNT)
    )
    half = replace(data, known=known)
    before = Judged(np.ones(COUNT), np.zeros_like(data.y))
    assert add_detail(half, before, angles, belief) == (None, before)


def test_deviations_hold_what_they_promise_of_new_samples(of_peak):
    detail, _ = of_peak
    at = angles_of(1500, seed=11)
    variance = detail.variance(at, np.zeros(1500)) + detail.belief.width**2
    error = np.abs(peak(at) + noise(1500, seed=12) - detail.at(at)).mean(axis=1)
    deviation = detail.calibration.unit * np.sqrt(variance)
    assert 0.55 < (error < deviation).mean() < 0.85
    assert (error < detail.calibration.deviations(0.95) * deviation).mean() > 0.88


def test_far_from_all_samples_the_stages_before_say_how_sure_it_is():
    theta_h, theta_d, phi_d = angles_of(COUNT, seed=3)
    near = 0.2 * theta_h, theta_d, phi_d
    detail, _ = fitted(np.sin(20.0 * np.sqrt(near[0]))[:, None] * np.ones((1, 2)), near)
    far = (np.full(1, 1.5), np.full(1, 1.0), np.zeros(1))
    assert np.abs(detail.at(far)).max() < 0.01
    assert detail.variance(far, np.full(1, 0.7))[0] > 0.65


@pytest.fixture
def eager(monkeypatch):
    """Detail from 300 samples on."""
    monkeypatch.setattr(module, "FEWEST", 300)


def toy_fit(toy, samples):
    """Fit a material that no member is like."""
    theta_h = samples.half_diff[0]
    ripple = np.exp(0.3 * np.sin(12.0 * np.sqrt(theta_h)))[:, None]
    return Posterior(population=toy, residual_size=60).fit(
        samples.with_value(samples.value * ripple)
    )


def test_a_fit_with_detail_says_the_same_everywhere(toy, measure, eager):
    samples = measure(n=900)
    result = toy_fit(toy, samples)
    assert result.model.detail is not None
    grid = Grid(30, 20, 24)
    dense = result.model.dense(grid, silent).reshape(grid.size, -1)[grid.cells]
    at = grid.directions(grid.cells)
    assert np.abs(np.log(dense) - np.log(result.evaluate(*at))).max() < 2e-3
    swapped = result.evaluate(at[1], at[0])
    assert np.allclose(np.log(swapped), np.log(result.evaluate(*at)), atol=1e-4)
    deviation = result.stddev(*at)
    assert (deviation > 0.0).all()
    assert np.isfinite(result.residuals[samples.usable]).all()
    assert result.history[-1]["detail_log_likelihood"] > 0.0


def test_the_order_of_samples_changes_no_detail(toy, measure, eager):
    samples = measure(n=900)
    order = np.random.default_rng(3).permutation(900)
    one, other = toy_fit(toy, samples), toy_fit(toy, samples.subset(order))
    assert np.array_equal(one.weights[order], other.weights)
    assert np.array_equal(
        one.evaluate(samples.wi, samples.wo), other.evaluate(samples.wi, samples.wo)
    )
