"""CUReT: a row of values for each material, directions in a table beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.geometry import directions_from_spherical

RNG = np.random.default_rng(5)
ANGLES = np.round(RNG.uniform([0, -3, 0, -3], [1.4, 3, 1.4, 3], (205, 4)), 6)
VALUES = np.round(RNG.uniform(0.05, 0.5, (3, 205)), 3)


def write(folder: Path) -> Path:
    table = "\r\n".join(f"{k + 1} " + " ".join(map(str, row)) for k, row in enumerate(ANGLES))
    (folder / "table.txt").write_bytes(table.encode())
    path = folder / "abrdf.dat"
    path.write_text("".join(f"{k + 1}   {' '.join(map(str, v))} \n" for k, v in enumerate(VALUES)))
    return path


def test_view_comes_first_and_the_light_second(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path), material=2)
    theta_v, phi_v, theta_i, phi_i = ANGLES.T
    np.testing.assert_allclose(samples.wo, directions_from_spherical(theta_v, phi_v))
    np.testing.assert_allclose(samples.wi, directions_from_spherical(theta_i, phi_i))
    np.testing.assert_array_equal(samples.value[:, 0], VALUES[1])
    assert samples.source.metadata == {"material": "2"}


def test_a_material_must_be_named_and_must_be_there(tmp_path: Path) -> None:
    path = write(tmp_path)
    with pytest.raises(UsageError, match=r"holds 3 materials.*1 to 3"):
        brdfit.read_samples(path)
    with pytest.raises(UsageError, match="no material 31"):
        brdfit.read_samples(path, material=31)
    assert len(brdfit.read_samples(path, material="3")) == 205


def test_one_material_needs_no_name(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.write_text(path.read_text().splitlines()[1])
    assert brdfit.read_samples(path).source.metadata == {"material": "2"}


def test_the_directions_must_be_there_and_whole(tmp_path: Path) -> None:
    path = write(tmp_path)
    table = (tmp_path / "table.txt").rename(tmp_path / "elsewhere.txt")
    with pytest.raises(FormatError, match=r"Put table\.txt beside it"):
        brdfit.read_samples(path, material=1)
    assert len(brdfit.read_samples(path, material=1, directions_file=table)) == 205
    table.write_text("\n".join(table.read_text().splitlines()[:100]))
    with pytest.raises(CorruptFile, match="found 100 directions"):
        brdfit.read_samples(path, material=1, directions_file=table)


def test_a_row_cut_short_is_corrupt_and_the_others_are_not(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.write_text(path.read_text()[:-200])
    with pytest.raises(CorruptFile, match=r"line 3: material 3 has \d+ fields but 206"):
        brdfit.read_samples(path, material=3)
    assert len(brdfit.read_samples(path, material=1)) == 205


def test_the_real_file_is_read(shared_data: Path) -> None:
    path = shared_data / "curet" / "abrdf_1_30.dat"
    for material in (1, 30):
        samples = brdfit.read_samples(path, material=material)
        assert samples.value.shape == (205, 1)
        assert not samples.flag_counts().get("below_horizon")
