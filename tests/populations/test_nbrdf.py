"""The decoded networks: the archive, the arithmetic of a network, and its symmetries."""

from __future__ import annotations

import math
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import DataQualityWarning, MissingExtra, PopulationError
from brdfit.geometry import directions_from_half_diff
from brdfit.populations import VALUE_FLOOR, Population, check, population
from brdfit.populations.nbrdf import read_nbrdf

h5py = pytest.importorskip("h5py")
Draw = Callable[[int], tuple[FloatArray, FloatArray]]
SHAPES = ((6, 21), (21, 21), (21, 3))


def write_network(path: Path, rng: np.random.Generator, inputs: int = 6) -> None:
    with h5py.File(path, "w") as file:
        for index, (rows, columns) in enumerate(SHAPES, start=1):
            group = file.create_group(f"dense_{index}/dense_{index}")
            kernel = rng.normal(0.0, 0.4, (inputs if index == 1 else rows, columns))
            group["kernel:0"] = kernel.astype("f4")
            group["bias:0"] = rng.normal(0.0, 0.2, columns).astype("f4")


@pytest.fixture
def archive(tmp_path: Path, rng: np.random.Generator) -> Path:
    """An archive of two made-up networks."""
    path = tmp_path / "networks.zip"
    with zipfile.ZipFile(path, "w") as target:
        for name in ("walnut", "brick"):
            write_network(tmp_path / f"{name}.h5", rng)
            target.write(tmp_path / f"{name}.h5", f"any_folder/{name}.h5")
        target.writestr("any_folder/walnut.json", "{}")
    return path


def test_a_network_is_its_arithmetic(archive: Path) -> None:
    networks = read_nbrdf(archive)
    assert networks.members == ("brick", "walnut")
    theta_h, theta_d, phi_d = 0.3, 0.5, 2.0
    wi, wo = directions_from_half_diff(theta_h, theta_d, phi_d)
    found = networks.evaluate(wi, wo, np.array([1]))[0, 0]

    signal = np.array(
        [
            math.sin(theta_h),
            0.0,
            math.cos(theta_h),
            math.sin(theta_d) * math.cos(phi_d),
            math.sin(theta_d) * math.sin(phi_d),
            math.cos(theta_d),
        ]
    )
    with zipfile.ZipFile(archive) as source, h5py.File(source.open("any_folder/walnut.h5")) as file:
        for index in (1, 2, 3):
            layer = file[f"dense_{index}/dense_{index}"]
            signal = signal @ layer["kernel:0"][...] + layer["bias:0"][...]
            if index < 3:
                signal = np.maximum(signal, 0.0)
    np.testing.assert_allclose(found, np.maximum(np.exp(signal) - 1.0, 0.0), rtol=1e-4, atol=1e-6)


def test_exchanging_light_and_detector_changes_nothing(
    archive: Path, random_directions: Draw
) -> None:
    networks = Population.of(read_nbrdf(archive))
    wi, wo = random_directions(500)
    np.testing.assert_allclose(
        networks.evaluate(wi, wo), networks.evaluate(wo, wi), rtol=1e-4, atol=1e-6
    )


def test_there_is_nothing_below_the_horizon(archive: Path) -> None:
    networks = Population.of(read_nbrdf(archive))
    up, down = np.array([[0.6, 0.0, 0.8]]), np.array([[0.6, 0.0, -0.8]])
    assert not networks.evaluate(up, down).any()


def test_an_archive_that_is_not_the_published_one_is_used_with_a_warning(archive: Path) -> None:
    with pytest.warns(DataQualityWarning, match=r"SHA-256 is .* but the published archive"):
        networks = population(archive)
    assert len(networks) == 2


def test_another_archive_has_another_fingerprint(archive: Path, tmp_path: Path) -> None:
    first = read_nbrdf(archive)
    with zipfile.ZipFile(archive, "a") as target:
        write_network(tmp_path / "oak.h5", np.random.default_rng(7))
        target.write(tmp_path / "oak.h5", "oak.h5")
    assert read_nbrdf(archive).fingerprint != first.fingerprint


def test_a_file_that_is_no_archive_is_named(tmp_path: Path) -> None:
    path = tmp_path / "broken.zip"
    path.write_bytes(b"PK not really")
    with pytest.raises(PopulationError, match=r"broken\.zip: not a readable zip archive"):
        population(path)


def test_an_archive_without_networks_says_what_was_expected(tmp_path: Path) -> None:
    path = tmp_path / "other.zip"
    with zipfile.ZipFile(path, "w") as target:
        target.writestr("readme.txt", "nothing here")
    with pytest.raises(PopulationError, match=r"no \.h5 file in the archive"):
        population(path)


def test_a_network_of_another_shape_names_its_layer(tmp_path: Path) -> None:
    write_network(tmp_path / "wide.h5", np.random.default_rng(3), inputs=8)
    path = tmp_path / "wide.zip"
    with zipfile.ZipFile(path, "w") as target:
        target.write(tmp_path / "wide.h5", "wide.h5")
    with pytest.raises(PopulationError, match=r"'wide': layer dense_1 has shape \(8, 21\)"):
        population(path)


def test_a_damaged_network_is_named(tmp_path: Path) -> None:
    path = tmp_path / "damaged.zip"
    with zipfile.ZipFile(path, "w") as target:
        target.writestr("oak.h5", b"\x89HDF no more")
    with pytest.raises(PopulationError, match="'oak'"):
        population(path)


def test_without_h5py_the_extra_is_named(archive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingExtra, match=r"brdfit\[networks\]"):
        read_nbrdf(archive)


def test_the_published_archive_is_known_and_mostly_above_the_floor(
    shared_data: Path, cache: Path, random_directions: Draw
) -> None:
    path = shared_data / "nbrdf" / "merl_nbrdf.zip"
    networks = population(path)
    assert len(networks) == 100
    assert networks.members == population("published").unique_materials
    assert check(path).ok
    value = networks.evaluate(*random_directions(300))
    assert value.shape == (300, 100, 3)
    assert np.mean(value < VALUE_FLOOR) < 0.02


def test_the_networks_and_the_published_fits_tell_of_the_same_materials(
    shared_data: Path, rng: np.random.Generator
) -> None:
    """A swapped convention (phi_d, channel order, member order) would not stay this close."""
    theta_h, theta_d = rng.uniform(0.2, 0.8, 400), rng.uniform(0.0, 0.6, 400)
    wi, wo = directions_from_half_diff(theta_h, theta_d, rng.uniform(0.0, np.pi, 400))
    networks = population(shared_data / "nbrdf" / "merl_nbrdf.zip").log_values(wi, wo)
    fits = population("published").log_values(wi, wo)
    for model, limit in (("shifted_gamma", 0.22), ("abc", 0.16)):
        members = population("published").subset(
            [name for name in population("published").members if name.endswith(model)]
        )
        difference = np.abs(fits[:, list(members.selected)] - networks)
        assert np.median(difference) < limit
