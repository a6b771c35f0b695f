"""Where a result comes from: believed samples nearby, and what they told."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from brdfit.geometry import directions_from_half_diff
from brdfit.grid import Grid
from brdfit.reconstruct import LocalBasis, Posterior
from brdfit.reconstruct.reach import FAR, NEAR, Reach
from brdfit.reconstruct.trust import Trust, TrustMap


@pytest.fixture
def method(toy):
    return Posterior(population=toy.without(["m4"]), residual_size=200)


@dataclass(frozen=True)
class States:
    """A model that states what it is told to."""

    stated: float
    prior: float = 1.0
    noise: float = 0.01

    def evaluate(self, wi, wo):
        return np.ones((len(wi), 1))

    def dense(self, grid, progress):
        return grid.spread(np.ones((grid.cells.size, 1)))

    def stddev(self, wi, wo):
        return np.full((len(wi), 3), self.stated)

    def prior_stddev(self, wi, wo):
        return np.full(len(wi), self.prior)


def around(samples, degrees):
    """Directions so many degrees of theta_d away from the first sample."""
    theta_h, theta_d, phi_d = (angle[:1] for angle in samples.half_diff)
    step = np.radians(degrees) * (1.0 if theta_d[0] < 0.7 else -1.0)
    return directions_from_half_diff(theta_h, theta_d + step, phi_d)


@pytest.fixture
def one_sample(measure):
    samples = measure(n=40)
    theta_h, theta_d, _ = samples.half_diff
    inside = np.flatnonzero((theta_h < 0.8) & (theta_d > 0.3) & (theta_d < 1.0))[:1]
    return samples.subset(inside)


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        (0.2, (Trust.MEASURED, Trust.INTERPOLATED, Trust.SUPPLIED)),
        (0.4, (Trust.INTERPOLATED, Trust.INTERPOLATED, Trust.SUPPLIED)),
        (0.9, (Trust.SUPPLIED, Trust.SUPPLIED, Trust.SUPPLIED)),
    ],
)
def test_nearness_is_no_promise_where_the_samples_told_little(one_sample, stated, expected):
    trust = TrustMap(Reach(one_sample), States(stated))
    found = [trust.evaluate(*around(one_sample, x))[0] for x in (NEAR - 2, FAR - 2, FAR + 2)]
    assert found == list(expected)


def test_as_sure_as_one_measurement_would_be_is_sure_enough(one_sample):
    at = around(one_sample, 1.0)
    # the population hardly differs there: no sample could take half of it away
    tight = States(stated=0.05, prior=0.06, noise=0.1)
    assert TrustMap(Reach(one_sample), tight).evaluate(*at) == Trust.MEASURED
    loose = replace(tight, prior=0.06, noise=0.001)
    assert TrustMap(Reach(one_sample), loose).evaluate(*at) == Trust.SUPPLIED


def test_a_measured_part_is_measured_and_the_rest_supplied(method, measure):
    samples = measure(n=400)
    part = samples.half_diff[0] < 0.5
    result = method.fit(samples.subset(part))
    assert result.trust_map.judges
    found = result.trust(samples.wi, samples.wo)
    assert np.mean(found[part] == Trust.MEASURED) > 0.9
    far = samples.half_diff[0] > 0.5 + np.radians(FAR + 1)
    assert (found[far] == Trust.SUPPLIED).all()
    assert set(found) == {1, 2, 3}


def test_what_is_named_as_an_outlier_supports_nothing(method, measure):
    samples = measure(n=200)
    theta_h, theta_d, _ = samples.half_diff
    apart = (theta_h > 0.6) & (theta_d > 0.4)
    value = samples.value.copy()
    value[apart] *= np.random.default_rng(2).choice([0.02, 50.0], apart.sum())[:, None]
    result = method.fit(samples.with_value(value))
    alone = apart & (Reach(samples, ~apart).degrees(*samples.half_diff) > FAR)
    assert alone.sum() > 3
    assert result.outliers[alone].all()
    assert (result.trust(samples.wi[alone], samples.wo[alone]) == Trust.SUPPLIED).all()


def test_a_method_without_uncertainty_goes_by_distance(measure):
    samples = measure(n=60)
    result = LocalBasis().fit(samples)
    assert not result.trust_map.judges
    found = result.trust(samples.wi, samples.wo)
    believed = ~result.outliers
    assert (found[believed] == Trust.MEASURED).all()
    below = -samples.wi[:2]
    assert (result.trust(below, samples.wo[:2]) == Trust.NOTHING).all()


def test_exchanging_light_and_detector_changes_no_class(method, measure):
    samples = measure(n=80)
    result = method.fit(samples.subset(np.arange(30)))
    assert np.array_equal(
        result.trust(samples.wi, samples.wo), result.trust(samples.wo, samples.wi)
    )


def test_the_map_on_a_grid_is_the_map_at_its_nodes(method, measure):
    result, grid = method.fit(measure(n=60)), Grid(8, 6, 4)
    dense = result.trust_map.on_grid(grid)
    assert dense.shape == grid.shape
    assert np.array_equal(dense.reshape(-1)[grid.cells], result.trust(*grid.directions(grid.cells)))
    below = np.setdiff1d(np.arange(grid.size), grid.cells)
    assert (dense.reshape(-1)[below] == Trust.NOTHING).all()


def test_before_any_sample_the_prior_is_less_sure_than_after(method, measure):
    samples = measure(n=300)
    model = method.fit(samples).model
    stated = model.stddev(samples.wi, samples.wo)[:, 0]
    assert (stated < model.prior_stddev(samples.wi, samples.wo)).mean() > 0.95
