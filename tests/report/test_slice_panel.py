"""The data of an interactive slice."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical
from brdfit.models import Lambert
from brdfit.reconstruct import Reconstruction
from brdfit.report.slice_panel import slice_panel
from brdfit.samples import Samples


def at(theta_i: float, phi_i: float, theta_o: float, phi_o: float) -> Samples:
    """Return one measurement; angles in degrees."""
    wi = directions_from_spherical(np.radians([theta_i]), np.radians([phi_i]))
    wo = directions_from_spherical(np.radians([theta_o]), np.radians([phi_o]))
    return Samples(wi=wi, wo=wo, value=np.array([0.5]))


def test_the_curve_is_the_brdf_in_that_plane(fit_known: Callable[..., Reconstruction]) -> None:
    result = fit_known()
    panel = slice_panel(result, theta_i=30.0)
    assert [curve.channel for curve in panel.curves] == ["R", "G", "B"]
    wi = directions_from_spherical(np.radians(30.0), np.radians(0.0))
    wo = directions_from_spherical(np.radians(30.0), np.radians(180.0))
    mirror = panel.theta_o.index(30.0)
    found = [curve.value[mirror] for curve in panel.curves]
    assert found == pytest.approx(result.evaluate(wi[None], wo[None])[0])
    # the peak stands on the mirror side
    assert int(np.argmax(panel.curves[0].value)) == mirror


def test_the_band_holds_95_percent_where_the_deviation_is_known() -> None:
    def deviation(wi: FloatArray, wo: FloatArray) -> FloatArray:
        return np.full((len(wi), 1), 0.1)

    panel = slice_panel(Lambert(np.array([0.2, 0.4, 0.6])), stddev=deviation, theta_i=20.0)
    for curve in panel.curves:
        assert curve.low is not None
        assert curve.high is not None
        np.testing.assert_allclose(np.log(np.divide(curve.high, curve.low)), 2 * 1.96 * 0.1)
    assert slice_panel(Lambert(np.ones(1)), theta_i=20.0).curves[0].low is None


@pytest.mark.parametrize(
    ("sample", "expected"),
    [
        ((40.0, 0.0, 25.0, 180.0), 25.0),
        ((40.0, 0.0, 25.0, 0.0), -25.0),
        ((41.0, 90.0, 25.0, 272.0), 25.0),  # turned about the normal, a little aside
        ((25.0, 0.0, 40.0, 180.0), 25.0),  # light and detector exchanged
        ((40.0, 0.0, 25.0, 120.0), None),  # out of the plane
        ((50.0, 0.0, 25.0, 180.0), None),  # another angle of the light
    ],
)
def test_a_sample_near_the_slice_is_drawn_at_its_signed_angle(
    sample: tuple[float, float, float, float], expected: float | None
) -> None:
    panel = slice_panel(Lambert(np.ones(1)), at(*sample), theta_i=40.0)
    assert [point.theta_o for point in panel.points] == (
        [] if expected is None else [pytest.approx(expected)]
    )


@pytest.mark.parametrize("turn", [120.0, -120.0])
def test_a_plane_aside_finds_its_samples_on_either_side(turn: float) -> None:
    panel = slice_panel(
        Lambert(np.ones(1)), at(40.0, 10.0, 25.0, 10.0 + turn), theta_i=40.0, phi=120
    )
    assert [point.theta_o for point in panel.points] == [pytest.approx(25.0)]


def test_outliers_are_never_thinned_out() -> None:
    n = 5000
    wi = np.tile(directions_from_spherical(np.radians(40.0), np.radians(0.0)), (n, 1))
    wo = directions_from_spherical(np.radians(np.linspace(1, 80, n)), np.full(n, np.pi))
    outliers = np.arange(n) % 100 == 3
    samples = Samples(wi=wi, wo=wo, value=np.ones(n))
    panel = slice_panel(Lambert(np.ones(1)), samples, outliers, theta_i=40.0)
    assert sum(point.outlier for point in panel.points) == outliers.sum()
    assert len(panel.points) + panel.points_left_out == n
    assert len(panel.points) < 1700


def test_an_angle_beyond_the_horizon_is_refused() -> None:
    with pytest.raises(UsageError, match="theta_i: found 95"):
        slice_panel(Lambert(np.ones(1)), theta_i=95.0)
