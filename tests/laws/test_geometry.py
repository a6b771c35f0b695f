"""Laws of the half/difference coordinates (Rusinkiewicz 1998), for any directions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brdfit.arrays import FloatArray, dot
from brdfit.errors import UsageError
from brdfit.geometry import (
    cos_incident_outgoing,
    directions_from_half_diff,
    directions_from_spherical,
    half_diff_from_directions,
    spherical_from_directions,
    split_by_horizon,
    wrap_phi_d,
)

QUARTER, HALF, FULL = np.pi / 2, np.pi, 2 * np.pi

# Near a pole an azimuth is worth nothing and near grazing a half vector is: each law says
# how far it stays from them, and the poles have laws of their own.
AWAY = 1e-3

thetas = st.floats(AWAY, QUARTER - AWAY)
azimuths = st.floats(-HALF, HALF)


@st.composite
def directions(draw: st.DrawFn) -> FloatArray:
    """A unit vector in the upper hemisphere, the pole and the horizon included."""
    return directions_from_spherical(draw(st.floats(0.0, QUARTER)), draw(azimuths))


def rotated(w: FloatArray, angle: float) -> FloatArray:
    """`w` turned about the normal."""
    c, s = np.cos(angle), np.sin(angle)
    return w @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def apart(a: FloatArray, b: FloatArray) -> FloatArray:
    """Distance of two azimuths around the circle."""
    return np.abs(np.mod(a - b + HALF, FULL) - HALF)


def well_conditioned(wi: FloatArray, wo: FloatArray) -> bool:
    """Neither pole, nor a half vector of two nearly opposite directions."""
    half = wi + wo
    length = np.linalg.norm(half)
    if length < 0.01:
        return False
    theta_h, theta_d, _ = half_diff_from_directions(wi, wo)
    return bool(theta_h > AWAY and theta_d > AWAY)


@given(thetas, thetas, st.floats(0.0, FULL, exclude_max=True))
def test_angles_to_directions_and_back_is_the_identity(
    theta_h: float, theta_d: float, phi_d: float
) -> None:
    back = half_diff_from_directions(*directions_from_half_diff(theta_h, theta_d, phi_d))
    np.testing.assert_allclose(back[:2], [theta_h, theta_d], atol=1e-9)
    assert apart(back[2], np.float64(phi_d)) < 1e-9


@given(directions(), directions())
def test_directions_to_angles_and_back_is_a_rotation_about_the_normal(
    wi: FloatArray, wo: FloatArray
) -> None:
    if not well_conditioned(wi, wo):
        return
    wi_back, wo_back = directions_from_half_diff(*half_diff_from_directions(wi, wo))
    half = wi + wo
    turn = float(np.arctan2(half[1], half[0]))
    np.testing.assert_allclose(rotated(wi_back, turn), wi, atol=1e-9)
    np.testing.assert_allclose(rotated(wo_back, turn), wo, atol=1e-9)


@given(directions(), directions())
def test_exchanging_light_and_detector_adds_half_a_turn_to_phi_d(
    wi: FloatArray, wo: FloatArray
) -> None:
    if not well_conditioned(wi, wo):
        return
    forward, backward = half_diff_from_directions(wi, wo), half_diff_from_directions(wo, wi)
    np.testing.assert_allclose(forward[:2], backward[:2], atol=1e-9)
    assert apart(forward[2] + HALF, backward[2]) < 1e-9
    assert apart(2 * wrap_phi_d(forward[2]), 2 * wrap_phi_d(backward[2])) < 1e-8


@given(directions(), directions(), azimuths)
def test_a_rotation_about_the_normal_changes_nothing(
    wi: FloatArray, wo: FloatArray, angle: float
) -> None:
    if not well_conditioned(wi, wo):
        return
    before = half_diff_from_directions(wi, wo)
    after = half_diff_from_directions(rotated(wi, angle), rotated(wo, angle))
    np.testing.assert_allclose(before[:2], after[:2], atol=1e-9)
    assert apart(before[2], after[2]) < 1e-9


@given(directions(), directions())
def test_a_reflection_in_a_plane_through_the_normal_negates_phi_d(
    wi: FloatArray, wo: FloatArray
) -> None:
    if not well_conditioned(wi, wo):
        return
    flip = np.array([1.0, -1.0, 1.0])
    before, after = (
        half_diff_from_directions(wi, wo),
        half_diff_from_directions(wi * flip, wo * flip),
    )
    np.testing.assert_allclose(before[:2], after[:2], atol=1e-9)
    assert apart(before[2], -after[2]) < 1e-9


@given(directions(), azimuths)
def test_mirror_pairs_have_no_half_angle_and_no_phi_d(wi: FloatArray, angle: float) -> None:
    mirror = wi * np.array([-1.0, -1.0, 1.0])
    if wi[2] < 1e-6:
        return
    theta_h, theta_d, phi_d = half_diff_from_directions(rotated(wi, angle), rotated(mirror, angle))
    assert theta_h < 1e-9
    assert phi_d == 0.0
    np.testing.assert_allclose(theta_d, np.arccos(np.clip(wi[2], -1, 1)), atol=1e-7)


@given(directions())
def test_retroreflection_has_no_difference_angle_and_no_phi_d(w: FloatArray) -> None:
    theta_h, theta_d, phi_d = half_diff_from_directions(w, w)
    np.testing.assert_allclose(theta_h, np.arctan2(np.hypot(w[0], w[1]), w[2]), atol=1e-12)
    assert theta_d < 1e-9
    assert phi_d == 0.0


@given(azimuths)
def test_two_opposite_grazing_directions_give_finite_angles(angle: float) -> None:
    wi = rotated(np.array([1.0, 0.0, 0.0]), angle)
    theta_h, theta_d, phi_d = half_diff_from_directions(wi, -wi)
    assert (theta_h, phi_d) == (0.0, 0.0)
    np.testing.assert_allclose(theta_d, QUARTER)


@given(directions(), directions())
def test_all_angles_are_in_their_ranges(wi: FloatArray, wo: FloatArray) -> None:
    theta_h, theta_d, phi_d = half_diff_from_directions(wi, wo)
    assert 0.0 <= theta_h <= QUARTER + 1e-9
    assert 0.0 <= theta_d <= QUARTER + 1e-9
    assert 0.0 <= phi_d < FULL


@given(st.floats(0.0, QUARTER), st.floats(0.0, QUARTER), st.floats(-10.0, 10.0))
def test_any_triple_gives_unit_vectors(theta_h: float, theta_d: float, phi_d: float) -> None:
    for w in directions_from_half_diff(theta_h, theta_d, phi_d):
        np.testing.assert_allclose(dot(w, w), 1.0, atol=1e-12)


@given(st.floats(0.0, QUARTER), st.floats(0.0, QUARTER), st.floats(0.0, FULL))
def test_the_cosines_agree_with_the_directions(
    theta_h: float, theta_d: float, phi_d: float
) -> None:
    wi, wo = directions_from_half_diff(theta_h, theta_d, phi_d)
    cosines = cos_incident_outgoing(theta_h, theta_d, phi_d)
    np.testing.assert_allclose(cosines, (wi[2], wo[2]), atol=1e-12)


@given(st.floats(-50.0, 50.0))
def test_wrapping_phi_d_changes_it_by_whole_half_turns(phi_d: float) -> None:
    wrapped = wrap_phi_d(np.float64(phi_d))
    assert 0.0 <= wrapped < HALF
    turns = (phi_d - wrapped) / HALF
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-9)


@pytest.mark.parametrize("tiny", [-1e-300, -1e-17, -0.0, 0.0])
def test_wrapping_a_tiny_negative_phi_d_does_not_give_pi(tiny: float) -> None:
    assert 0.0 <= wrap_phi_d(np.float64(tiny)) < HALF


@given(st.floats(0.0, HALF), azimuths)
def test_spherical_angles_round_trip(theta: float, phi: float) -> None:
    w = directions_from_spherical(theta, phi)
    np.testing.assert_allclose(dot(w, w), 1.0, atol=1e-12)
    np.testing.assert_allclose(
        directions_from_spherical(*spherical_from_directions(w)), w, atol=1e-12
    )


@given(st.floats(0.0, QUARTER), azimuths)
def test_a_negative_theta_is_the_opposite_azimuth(theta: float, phi: float) -> None:
    np.testing.assert_allclose(
        directions_from_spherical(-theta, phi),
        directions_from_spherical(theta, phi + HALF),
        atol=1e-12,
    )


def test_phi_d_is_zero_where_the_light_is_farther_from_the_normal() -> None:
    # half vector 30 degrees off the normal, the light 20 degrees beyond it, in one plane
    wi, wo = directions_from_spherical(np.radians([50.0, 10.0]), np.zeros(2))
    angles = np.degrees(half_diff_from_directions(wi, wo))
    np.testing.assert_allclose(angles, [30.0, 20.0, 0.0], atol=1e-9)


def test_arrays_of_any_shape_give_what_single_pairs_give(rng: np.random.Generator) -> None:
    wi, wo = (
        directions_from_spherical(rng.uniform(0, QUARTER, (2, 5)), rng.uniform(-3, 3, (2, 5)))
        for _ in range(2)
    )
    together = np.array(half_diff_from_directions(wi, wo))
    for index in np.ndindex(2, 5):
        one = np.array(half_diff_from_directions(wi[index], wo[index]))
        np.testing.assert_allclose(together[(slice(None), *index)], one, atol=1e-12)


def test_the_horizon_belongs_to_what_is_below() -> None:
    up, level, lost = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, np.nan, 1.0]
    finite, above = split_by_horizon(np.array([up, up, up]), np.array([up, level, lost]))
    assert finite.tolist() == [True, True, False]
    assert above.tolist() == [True, False, False]


def test_directions_that_do_not_pair_up_are_named() -> None:
    with pytest.raises(UsageError, match="wi has 2 rows but wo has 3"):
        split_by_horizon(np.zeros((2, 3)), np.zeros((3, 3)))
