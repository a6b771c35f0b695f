from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_half_diff, directions_from_spherical
from brdfit.report.coverage import Reach, coverage_of
from brdfit.samples import Samples

Draw = Callable[[int], tuple[FloatArray, FloatArray]]


def _samples(wi: FloatArray, wo: FloatArray) -> Samples:
    return Samples(wi=wi, wo=wo, value=np.ones((len(wi), 1)))


def _one_sample() -> Samples:
    angles = np.radians([[20.0], [30.0], [90.0]])
    return _samples(*directions_from_half_diff(*angles))


def test_ranges_are_those_of_the_angles_in_degrees() -> None:
    theta_i = np.radians([10.0, 60.0])
    wi = directions_from_spherical(theta_i, np.zeros(2))
    wo = directions_from_spherical(np.radians([20.0, 60.0]), np.full(2, np.pi))
    coverage = coverage_of(_samples(wi, wo))
    assert coverage is not None
    assert coverage.theta_i == pytest.approx((10.0, 60.0))
    assert coverage.theta_o == pytest.approx((20.0, 60.0))
    # both in the plane of incidence: half angles (20 - 10) / 2 and 0
    assert coverage.theta_h == pytest.approx((0.0, 5.0), abs=1e-6)
    assert coverage.theta_d == pytest.approx((15.0, 60.0))


def test_many_random_samples_cover_nearly_all_and_one_covers_little(
    random_directions: Draw,
) -> None:
    many = coverage_of(_samples(*random_directions(30_000)))
    one = coverage_of(_samples(*random_directions(1)))
    assert many is not None
    assert one is not None
    assert many.share > 0.97
    assert one.share < 0.01


def test_exchanging_light_and_detector_changes_no_share(random_directions: Draw) -> None:
    wi, wo = random_directions(50)
    one, other = coverage_of(_samples(wi, wo)), coverage_of(_samples(wo, wi))
    assert one is not None
    assert other is not None
    assert one.share == pytest.approx(other.share)
    assert 0.0 < one.share < 1.0


def test_without_a_usable_sample_there_is_no_coverage() -> None:
    down = np.array([[0.0, 0.0, -1.0]])
    assert coverage_of(_samples(down, down)) is None


def test_reach_is_the_angle_to_the_nearest_sample_and_infinite_beyond_what_is_asked() -> None:
    reach = Reach(_one_sample())
    phi = np.full(4, np.pi / 2)
    theta_h = np.radians([20.0, 24.0, 20.0, 60.0])
    theta_d = np.radians([30.0, 30.0, 40.0, 30.0])
    found = reach.degrees(theta_h, theta_d, phi)
    assert found == pytest.approx([0.0, 4.0, 10.0, np.inf], abs=0.5)
    # light and detector exchanged: the same direction
    assert reach.degrees(theta_h[:1], theta_d[:1], phi[:1] + np.pi) == pytest.approx(0.0, abs=1e-6)


def test_what_is_near_and_what_is_interpolated_are_apart() -> None:
    few = coverage_of(_one_sample())
    assert few is not None
    assert 0.0 < few.share < few.share_between < 1.0
    assert few.share + few.share_between < 0.2
