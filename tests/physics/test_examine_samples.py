"""Each check of measurements finds the fault that was put in, and none where none is."""

from __future__ import annotations

import json

import numpy as np
import pytest

from brdfit.geometry import directions_from_spherical, half_diff_from_directions
from brdfit.models import Ggx, Lambert
from brdfit.physics import Verdict, directional_albedo, examine
from brdfit.physics.alignment import find_alignment
from brdfit.samples import Samples

PAINT = Ggx(diffuse=[0.3, 0.2, 0.1], f0=0.05, alpha=0.15)


def test_measurements_in_order_are_found_good_by_every_check(measured):
    health = examine(measured(PAINT, noise=0.01))
    assert health.kind == "samples"
    assert {f.name: f.verdict for f in health.findings} == dict.fromkeys(
        ("cells", "reciprocity", "energy", "grazing", "symmetry", "peak"), Verdict.GOOD
    )
    assert health.worst is Verdict.GOOD
    json.dumps(health.record(), allow_nan=False)


def test_a_cosine_that_was_left_in_the_values_breaks_reciprocity(measured):
    samples = measured(PAINT)
    finding = examine(samples.with_value(samples.value * samples.wo[:, 2:]))["reciprocity"]
    assert finding.verdict is Verdict.WRONG
    assert finding.figure > 0.25
    assert finding.details["pairs"] > 20


def test_the_figure_of_reciprocity_is_the_difference_that_was_put_in(measured):
    samples = measured(Lambert(0.5))
    # brighter by 8 % where the light is higher than the detector
    factor = np.where(samples.wi[:, 2] > samples.wo[:, 2] + 1e-9, 1.08, 1.0)
    finding = examine(samples.with_value(samples.value * factor[:, None]))["reciprocity"]
    assert finding.figure == pytest.approx(np.log(1.08), rel=1e-6)
    assert finding.verdict is Verdict.LOOK
    assert "8.0%" in finding.sentence


def test_without_exchanged_directions_nothing_is_claimed(measured):
    samples = measured(PAINT)
    finding = examine(samples.subset(samples.wi[:, 2] > samples.wo[:, 2] + 0.01))["reciprocity"]
    assert finding.verdict is Verdict.UNKNOWN
    assert finding.figure is None


def test_more_light_than_arrives_is_found_and_where(measured):
    finding = examine(measured(Ggx(diffuse=[0.2, 1.3], f0=0.05, alpha=0.4), step=5.0))["energy"]
    assert finding.verdict is Verdict.WRONG
    assert finding.details["worst_channel"] == "channel1"
    assert "above 1 at" in finding.sentence


def test_the_albedo_of_scans_is_that_of_the_surface_over_what_was_measured(measured):
    finding = examine(measured(PAINT, step=5.0))["energy"]
    theta = np.radians(finding.details["theta_i_degrees"])
    found = np.array(list(finding.details["albedo"].values())).T
    expected = directional_albedo(PAINT, theta)
    assert (np.array(finding.details["covered"]) > 0.9).all()
    middle = theta < np.radians(60.0)
    np.testing.assert_allclose(found[middle], expected[middle], rtol=0.12)
    assert "lower bound" in finding.sentence


def test_one_plane_of_incidence_says_nothing_of_the_albedo(measured):
    samples = measured(PAINT)
    planar = samples.subset(np.abs(samples.wo[:, 1]) < 1e-6)
    assert examine(planar)["energy"].verdict is Verdict.UNKNOWN


@pytest.mark.parametrize("noise", [0.1, 0.3])
def test_the_noise_near_grazing_is_what_was_put_in(measured, noise):
    samples = measured(Lambert(0.4), step=3.0)
    grazing = np.minimum(samples.wi[:, 2], samples.wo[:, 2]) < np.cos(np.radians(75.0))
    scatter = np.random.default_rng(1).lognormal(0.0, noise, len(samples))
    value = samples.value * np.where(grazing, scatter, 1.0)[:, None]
    finding = examine(samples.with_value(value))["grazing"]
    assert finding.figure == pytest.approx(noise, rel=0.2)
    assert finding.details["inside"] < 0.02
    assert finding.verdict is (Verdict.LOOK if noise < 0.25 else Verdict.WRONG)


def test_one_brighter_side_is_found(measured):
    samples = measured(Lambert(0.4))
    _, _, phi_d = half_diff_from_directions(samples.wi, samples.wo)
    side = np.where((phi_d > 0.0) & (phi_d < np.pi), 1.4, 1.0)
    finding = examine(samples.with_value(samples.value * side[:, None]))["symmetry"]
    assert finding.figure == pytest.approx(np.log(1.4), rel=0.05)
    assert finding.verdict is Verdict.WRONG


@pytest.mark.parametrize("tilt", [-4.0, 3.0])
@pytest.mark.parametrize("alpha", [0.1, 0.2])
def test_a_tilted_sample_is_found_with_its_angle_and_side(measured, tilt, alpha):
    samples = measured(Ggx(diffuse=0.1, f0=0.05, alpha=alpha), tilt=tilt, noise=0.02, step=5.0)
    samples = samples.subset(samples.usable.any(axis=1) & (samples.value[:, 0] > 0.0))
    found = find_alignment(samples)
    assert found.degrees == pytest.approx(abs(tilt), abs=max(0.5, 2.0 * found.uncertainty))
    # the light is at azimuth 0, and a positive tilt moves the peak away from it
    assert np.sign(found.along) == np.sign(tilt)
    assert abs(found.across) < 0.5


def test_a_peak_that_is_off_is_said_in_degrees(measured):
    finding = examine(measured(Ggx(diffuse=0.1, f0=0.05, alpha=0.1), tilt=4.0, step=4.0))["peak"]
    assert finding.verdict is Verdict.WRONG
    assert finding.unit == "degrees"
    assert finding.figure == pytest.approx(4.0, abs=0.6)


def test_a_surface_without_a_peak_has_no_position_of_it(measured):
    assert examine(measured(Lambert(0.5)))["peak"].verdict is Verdict.UNKNOWN


def test_noise_floor_and_unusable_rows_are_counted(measured):
    samples = measured(Lambert(0.5))
    value = np.array(samples.value)
    value[:40], value[40:50], value[50:55] = 0.0, -1e-3, np.nan
    finding = examine(samples.with_value(value))["cells"]
    counts = {name: finding.details[name] for name in ("zero", "negative", "unusable")}
    assert counts == {"zero": 40, "negative": 10, "unusable": 5}
    assert finding.figure == pytest.approx(55 / len(samples))


def test_a_handful_of_samples_gives_findings_not_errors():
    straight = np.tile([0.0, 0.0, 1.0], (3, 1))
    health = examine(Samples(wi=straight, wo=straight, value=np.full((3, 1), np.nan)))
    assert {f.verdict for f in health.findings[1:]} == {Verdict.UNKNOWN}
    assert examine(Samples(wi=straight[:0], wo=straight[:0], value=np.zeros((0, 1))))["cells"]


def test_real_measurements_are_found_in_order(shared_data):
    from brdfit import read_samples

    health = examine(read_samples(shared_data / "nist" / "PTFE.data.csv", wavelength=532))
    # sintered PTFE is a reflectance standard: nearly white, nearly Lambertian
    assert health["reciprocity"].verdict is Verdict.GOOD
    assert health["symmetry"].verdict is Verdict.GOOD
    assert 0.85 < health["energy"].figure < 1.0


def test_dark_bands_are_counted_by_their_values_and_are_no_fault():
    rng = np.random.default_rng(3)
    value = rng.uniform(0.1, 0.2, (40, 4))
    value[:38, 3] = 0.0
    w = directions_from_spherical(rng.uniform(0.1, 1.2, (2, 40)), rng.uniform(0, 6, (2, 40)))
    names = ("400nm", "500nm", "600nm", "700nm")
    finding = examine(Samples(wi=w[0], wo=w[1], value=value, channels=names))["cells"]
    assert finding.figure == pytest.approx(38 / 160)
    assert "38 hold a zero: in all 23.8% of the values, most in 700nm, where it is 95%" in (
        finding.sentence
    )
    assert finding.details["lost_by_channel"]["700nm"] == pytest.approx(0.95)
    value[:, 2] = value[:, 3]
    assert examine(Samples(wi=w[0], wo=w[1], value=value))["cells"].verdict is Verdict.LOOK
    value[:, 2:] = -1.0
    negative = examine(Samples(wi=w[0], wo=w[1], value=value))["cells"]
    assert negative.verdict is Verdict.WRONG
    assert "40 hold a negative value (down to -1 1/sr)" in negative.sentence


def test_samples_without_fault_are_said_to_be_so():
    w = np.array([[0.0, 0.0, 1.0]] * 12)
    finding = examine(Samples(wi=w, wo=w, value=np.ones((12, 1))))["cells"]
    assert finding.sentence == "all 12 samples can be used, and no value is zero or negative"


def test_why_samples_cannot_be_used_is_counted():
    w = np.array([[0.0, 0.0, 1.0]] * 12)
    down = np.where(np.arange(12)[:, None] < 3, -w, w)
    finding = examine(Samples(wi=w, wo=down, value=np.ones((12, 1))))["cells"]
    assert "of 12 samples 3 cannot be used (3 below horizon): in all 25.0%" in finding.sentence


def test_an_anisotropic_sample_is_named_where_exchanged_values_disagree():
    rng = np.random.default_rng(5)
    theta = rng.uniform(0.2, 1.2, (2, 60))
    wi, wo = directions_from_spherical(theta, rng.uniform(0.0, 6.0, (2, 60)))
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    # exchanged, and the sample turned by a right angle: brighter along its grain
    value = np.concatenate([np.full(60, 0.2), np.full(60, 0.5)])[:, None]
    samples = Samples(wi=np.vstack([wi, wo @ turn]), wo=np.vstack([wo, wi @ turn]), value=value)
    finding = examine(samples)["reciprocity"]
    assert finding.verdict is Verdict.WRONG
    assert "anisotropic" in finding.sentence
