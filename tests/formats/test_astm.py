"""ASTM E1392 as Cornell wrote it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, DataQualityWarning, UnknownFormat
from brdfit.geometry import half_diff_from_directions
from brdfit.samples import Flag

HEADER = """LAB_NAME A laboratory
LAB_COMMENTS blue
LAB_COMMENTS and gloss

SAMPLE_NAME Blue
NUM_POINTS {n}
VARS theta_i,phi_i,theta_s,phi_s,400nm,410nm,500nm

"""
ROWS = [f"0.{r},0.000000,0.{r},3.141593,0.1,0.000000,{r}.5" for r in range(10, 30)]


def write(folder: Path, rows: list[str], n: int | str | None = None, end: str = "\n") -> Path:
    path = folder / "blue.astm"
    text = HEADER.format(n=len(rows) if n is None else n) + "\n".join(rows) + "\n"
    path.write_bytes(text.replace("\n", end).encode())
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_the_specular_direction_is_at_phi_s_of_pi(tmp_path: Path, end: str) -> None:
    samples = brdfit.read_samples(write(tmp_path, ROWS, end=end))
    theta_h, theta_d, _ = half_diff_from_directions(samples.wi, samples.wo)
    np.testing.assert_allclose(theta_h, 0.0, atol=1e-6)
    np.testing.assert_allclose(theta_d, np.arange(10, 30) / 100, atol=1e-6)
    assert samples.wavelengths is not None
    assert samples.wavelengths.tolist() == [400.0, 410.0, 500.0]
    assert samples.rows is not None
    assert samples.rows[0] == 9


def test_exact_zeros_stay_as_values_and_are_censored(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path, ROWS))
    assert (samples.value[:, 1] == 0.0).all()
    assert samples.flag_counts() == {"censored": 20}


def test_the_header_travels_along(tmp_path: Path) -> None:
    source = brdfit.read_samples(write(tmp_path, ROWS)).source
    assert source.metadata["LAB_COMMENTS"] == "blue; and gloss"
    assert source.metadata["SAMPLE_NAME"] == "Blue"
    assert "radians" in source.convention


@pytest.mark.parametrize(("n", "what"), [(21, "truncated"), (19, "Rows were added")])
def test_a_wrong_number_of_rows_names_both_and_the_line(tmp_path: Path, n: int, what: str) -> None:
    with pytest.raises(CorruptFile, match=rf"line 6: NUM_POINTS says {n} but 20 rows.*{what}"):
        brdfit.read_samples(write(tmp_path, ROWS, n))


def test_a_number_of_rows_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(CorruptFile, match="line 6: NUM_POINTS is 'many'"):
        brdfit.read_samples(write(tmp_path, ROWS, "many"))


def test_a_row_cut_short_is_flagged(tmp_path: Path) -> None:
    rows = [*ROWS[:-1], ROWS[-1][:20]]
    with pytest.warns(DataQualityWarning, match="1 unreadable, rows 28"):
        samples = brdfit.read_samples(write(tmp_path, rows))
    assert samples.bits[-1] & Flag.UNREADABLE


def test_a_header_without_rows_or_without_names_is_told(tmp_path: Path) -> None:
    with pytest.raises(CorruptFile, match="no row of measurements"):
        brdfit.read_samples(write(tmp_path, []))
    path = tmp_path / "cut.astm"
    path.write_text("LAB_NAME A\nSAMPLE_NAME B\nNUM_POINTS 1439\n")
    with pytest.raises(UnknownFormat, match="no line VARS"):
        brdfit.read_samples(path)


def test_columns_that_are_no_directions_are_told(tmp_path: Path) -> None:
    path = write(tmp_path, ROWS)
    path.write_text(path.read_text().replace("theta_s", "elevation"))
    with pytest.raises(CorruptFile, match="VARS names the columns theta_i, phi_i, elevation"):
        brdfit.read_samples(path)


@pytest.mark.parametrize("name", ["acryl_blue", "cayman", "krylon_blue"])
def test_the_cornell_paints_are_read_whole(shared_data: Path, name: str) -> None:
    samples = brdfit.read_samples(shared_data / "cornell" / f"{name}.astm")
    assert samples.value.shape == (1439, 31)
    assert samples.wavelengths is not None
    np.testing.assert_array_equal(samples.wavelengths, np.arange(400, 701, 10))
    brightest = np.argsort(np.nanmax(samples.value, axis=1))[-10:]
    assert (samples.half_diff[0][brightest] < np.deg2rad(15)).all()
