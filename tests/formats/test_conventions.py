"""Data that contradict their convention are named; sound data are left alone."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.arrays import FloatArray
from brdfit.errors import BrdfitWarning, ConventionWarning, DataQualityWarning
from brdfit.formats.convention_check import check_conventions
from brdfit.geometry import (
    directions_from_spherical,
    half_diff_from_directions,
    spherical_from_directions,
)
from brdfit.samples import Flag, Samples

RGL = ("aurora_white", "chm_mint", "paper_white", "satin_rosaline", "vch_golden_yellow")
REAL = [
    *(f"cornell/{name}.astm" for name in ("acryl_blue", "cayman", "krylon_blue")),
    "nist/PTFE.data.csv",
    *(f"rgl/{name}_rgb.bsdf" for name in RGL),
]


def kinds(samples: Samples) -> list[str]:
    return [found.kind for found in check_conventions(samples)]


def read(path: Path, **options: object) -> Samples:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataQualityWarning)
        return brdfit.read_samples(path, **options)


def azimuth_turned(samples: Samples) -> Samples:
    return replace(samples, wo=samples.wo * np.array([-1.0, -1.0, 1.0]))


def with_angles_times(samples: Samples, factor: float) -> Samples:
    def times(w: FloatArray) -> FloatArray:
        theta, phi = spherical_from_directions(w)
        return directions_from_spherical(factor * theta, factor * phi)

    put_aside = samples.bits & int(Flag.REJECTED)
    return replace(samples, wi=times(samples.wi), wo=times(samples.wo), flags=put_aside)


@pytest.fixture
def glossy() -> Samples:
    """A diffuse material with a lobe, on pairs that exchange light and detector."""
    rng = np.random.default_rng(11)
    theta = np.deg2rad(rng.uniform(5, 75, (2, 400)))
    phi = rng.uniform(-np.pi, np.pi, (2, 400))
    phi[1, :200] = phi[0, :200] + np.pi + rng.normal(0, 0.1, 200)
    theta[1, :200] = theta[0, :200] + rng.normal(0, 0.05, 200)
    one, other = directions_from_spherical(theta, phi)
    wi, wo = np.vstack([one, other]), np.vstack([other, one])
    theta_h, _, _ = half_diff_from_directions(wi, wo)
    value = 0.1 + 20 * np.exp(-((theta_h / 0.12) ** 2))
    return Samples(wi=wi, wo=wo, value=value)


@pytest.mark.parametrize("file", REAL)
def test_real_files_contradict_nothing(shared_data: Path, file: str) -> None:
    assert kinds(read(shared_data / file)) == []


def test_no_material_of_curet_contradicts_anything(shared_data: Path) -> None:
    for material in range(1, 31):
        samples = read(shared_data / "curet" / "abrdf_1_30.dat", material=material)
        assert kinds(samples) == [], material


@pytest.mark.parametrize("file", REAL)
def test_an_azimuth_turned_by_pi_is_seen_in_real_files(shared_data: Path, file: str) -> None:
    assert kinds(azimuth_turned(read(shared_data / file))) == ["azimuth"]


def test_an_azimuth_turned_is_seen_in_most_materials_of_curet(shared_data: Path) -> None:
    path = shared_data / "curet" / "abrdf_1_30.dat"
    seen = [
        material
        for material in range(1, 31)
        if kinds(azimuth_turned(read(path, material=material))) == ["azimuth"]
    ]
    # plaster, felt and the like send as much light back as forward: nothing can be told
    assert len(seen) >= 23
    assert {10, 11, 30}.isdisjoint(seen)


@pytest.mark.parametrize("file", REAL)
def test_wrong_units_are_seen_in_real_files(shared_data: Path, file: str) -> None:
    samples = read(shared_data / file)
    assert kinds(with_angles_times(samples, 180 / np.pi)) == ["below horizon"]
    assert kinds(with_angles_times(samples, np.pi / 180)) == ["crowded"]


def test_a_cosine_is_seen_where_light_and_detector_were_exchanged(shared_data: Path) -> None:
    samples = read(shared_data / "nist" / "PTFE.data.csv")
    cos_i, cos_o = samples.wi[:, 2:], samples.wo[:, 2:]
    for factor, said in (
        (cos_o, "still hold the cosine"),
        (cos_i, "cosine of the light"),
        (1 / cos_o, "without need"),
        (cos_i / cos_o, "light and detector are probably exchanged"),
    ):
        (found,) = check_conventions(samples.with_value(samples.value * factor))
        assert found.kind == "cosine"
        assert said in found.message


def test_light_and_detector_exchanged_leave_no_mark(glossy: Samples) -> None:
    assert kinds(glossy) == []
    assert kinds(replace(glossy, wi=glossy.wo, wo=glossy.wi)) == []


def test_one_wrong_measurement_decides_nothing(glossy: Samples) -> None:
    value = glossy.value.copy()
    retro = np.argmax(np.einsum("ni,ni->n", glossy.wi, glossy.wo))
    value[retro] = 1e6
    assert kinds(glossy.with_value(value)) == []


def test_a_share_of_wrong_measurements_raises_no_alarm(shared_data: Path) -> None:
    samples = read(shared_data / "cornell" / "krylon_blue.astm")
    rng = np.random.default_rng(3)
    value = samples.value.copy()
    wrong = rng.random(len(value)) < 0.4
    value[wrong] *= 10 ** rng.uniform(-1, 1, (wrong.sum(), 1))
    assert kinds(samples.with_value(value)) == []


def test_too_few_or_unusable_samples_contradict_nothing(glossy: Samples) -> None:
    assert kinds(glossy.subset(np.arange(3))) == []
    assert kinds(glossy.subset(np.arange(0))) == []
    assert kinds(glossy.with_flags(np.ones(len(glossy), bool), Flag.REJECTED)) == []
    assert kinds(glossy.with_value(np.full(len(glossy), np.nan))) == []
    assert kinds(replace(glossy, wi=glossy.wi * np.nan)) == []


def test_the_front_door_warns_with_the_name_of_the_file(tmp_path: Path, glossy: Samples) -> None:
    brdfit.write_samples(azimuth_turned(glossy), tmp_path / "turned.csv")
    with pytest.warns(ConventionWarning, match=r"turned\.csv: the specular peak"):
        brdfit.read_samples(tmp_path / "turned.csv")


def test_degrees_declared_as_radians_give_a_result_and_a_warning(
    tmp_path: Path, glossy: Samples
) -> None:
    angles = np.rad2deg(
        [*spherical_from_directions(glossy.wi), *spherical_from_directions(glossy.wo)]
    )
    path = tmp_path / "x.csv"
    np.savetxt(path, np.vstack([angles, glossy.value.T]).T, delimiter=",")
    declared = {"directions": [1, 2, 3, 4], "values": [5]}
    with pytest.warns(BrdfitWarning) as caught:
        samples = brdfit.read_samples(path, **declared, angles="radians")
    assert len(samples) == len(glossy)
    assert any("in degrees but were read as radians" in str(w.message) for w in caught)
    assert kinds(brdfit.read_samples(path, **declared, angles="degrees")) == []
