"""What a fit compares with: values where there are any, bounds where they are censored."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.errors import SampleError
from brdfit.reconstruct.targets import Targets, pooled


@pytest.fixture
def samples(measure):
    """Return four samples: good, a zero in red, blue missing, a negative everywhere."""
    value = np.array([[1.0, 2.0, 3.0], [0.0, 2.0, 3.0], [1.0, 2.0, np.nan], [-1.0, -1.0, -1.0]])
    return measure(n=4).with_value(value)


def test_values_are_logarithms_and_bounds_stand_at_the_floor(samples):
    targets = Targets.of(samples)
    assert np.allclose(targets.log_value[0], np.log([1.0, 2.0, 3.0]))
    assert targets.log_value[1, 0] == pytest.approx(np.log(samples.noise_floor[0]))
    assert np.allclose(targets.log_value[3], np.log(samples.noise_floor))
    assert np.isnan(targets.log_value[2, 2])
    assert targets.usable.sum() == 11
    assert targets.censored.sum() == 4


def test_a_bound_speaks_only_where_the_estimate_is_above_it(samples):
    targets = Targets.of(samples)
    floor = np.log(samples.noise_floor)
    for step, speaks in ((-0.1, False), (0.0, False), (0.1, True)):
        estimate = np.tile(floor + step, (4, 1))
        assert targets.informative(estimate)[3].tolist() == [speaks] * 3
        assert np.allclose(targets.residual(estimate)[3], -step if speaks else 0.0)
    assert targets.informative(np.zeros((4, 3)))[0].all()
    assert not targets.informative(np.zeros((4, 3)))[2, 2]
    assert np.isnan(targets.residual(np.zeros((4, 3)))[2, 2])


def test_taking_rows_takes_them(samples):
    some = Targets.of(samples).take(np.array([False, True, True, False]))
    assert some.log_value.shape == (2, 3)
    assert some.censored[0, 0]


def test_a_channel_without_a_positive_value_is_named(samples):
    value = samples.value.copy()
    value[:, 2] = np.minimum(value[:, 2], 0.0)
    with pytest.raises(SampleError, match=r"channel B .*select_channels"):
        Targets.of(samples.with_value(value))


def test_pooling_is_the_mean_over_what_is_known():
    values = np.array([[1.0, 3.0, 99.0], [5.0, 7.0, 9.0], [1.0, 1.0, 1.0]])
    known = np.array([[True, True, False], [True, True, True], [False, False, False]])
    assert pooled(values, known, per_channel=False).tolist() == [
        [2.0, 2.0, 0.0],
        [7.0, 7.0, 7.0],
        [0.0, 0.0, 0.0],
    ]
    assert pooled(values, known, per_channel=True)[0].tolist() == [1.0, 3.0, 0.0]
