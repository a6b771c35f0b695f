"""NIST's CSV: degrees, theta_i stored negative, wavelengths in blocks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, DataQualityWarning, UsageError
from brdfit.geometry import spherical_from_directions
from brdfit.samples import Flag

HEADER = "lambda,thetai,phi,thetar,phir,f_r11,f_r12/f_r11\n"


def row(wave: float, theta_i: float, theta_r: float, phi_r: float, value: float) -> str:
    return f"{wave},{theta_i},0,{theta_r},{phi_r},{value:.2E},-0.01"


def block(wave: float, scale: float = 1.0) -> list[str]:
    return [row(wave, -10 * k - 1, 10 * k, 20.0, scale * (k + 1)) for k in range(8)]


def write(folder: Path, rows: list[str]) -> Path:
    path = folder / "PTFE.csv"
    path.write_text(HEADER + "\n".join(rows) + "\n")
    return path


# these files are short on purpose
pytestmark = pytest.mark.filterwarnings("ignore:.*usable samples:brdfit.errors.DataQualityWarning")


def test_a_negative_theta_i_is_the_light_at_azimuth_180(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path, block(0.532)))
    theta_i, phi_i = spherical_from_directions(samples.wi)
    np.testing.assert_allclose(np.rad2deg(theta_i), 10 * np.arange(8) + 1)
    np.testing.assert_allclose(np.abs(np.rad2deg(phi_i)), 180.0)
    theta_o, phi_o = spherical_from_directions(samples.wo[1:])
    np.testing.assert_allclose(np.rad2deg(theta_o), 10 * np.arange(1, 8))
    np.testing.assert_allclose(np.rad2deg(phi_o), 20.0)


def test_wavelengths_at_the_same_directions_are_channels(tmp_path: Path) -> None:
    rows = block(0.351, 2.0) + block(1.064)
    samples = brdfit.read_samples(write(tmp_path, rows))
    assert samples.channels == ("351nm", "1064nm")
    np.testing.assert_allclose(samples.value[:, 0], 2.0 * samples.value[:, 1])
    assert samples.rows is not None
    assert samples.rows.tolist() == list(range(2, 10))


def test_the_order_of_the_rows_does_not_matter(tmp_path: Path) -> None:
    rows = block(0.351) + block(1.064, 2.0)[::-1]
    samples = brdfit.read_samples(write(tmp_path, rows))
    np.testing.assert_allclose(samples.value[:, 1], 2.0 * samples.value[:, 0])


def test_repeated_measurements_stay_apart(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path, block(0.351) + block(0.351, 3.0)))
    assert len(samples) == 16
    assert samples.flag_counts() == {"duplicate": 8}


def test_a_wavelength_that_misses_a_direction_is_missing_there(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path, block(0.351) + block(1.064)[1:]))
    assert samples.flag_counts() == {"partly_missing": 1}
    assert np.isnan(samples.value[0, 1])


def test_different_directions_ask_for_a_wavelength(tmp_path: Path) -> None:
    other = [row(0.9, -15.0, 10 * k + 5, 70.0, 1.0) for k in range(8)]
    path = write(tmp_path, block(0.351) + other)
    with pytest.raises(UsageError, match=r"wavelength=\.\.\. of 351, 900"):
        brdfit.read_samples(path)
    samples = brdfit.read_samples(path, wavelength=900)
    assert samples.channels == ("900nm",)
    assert len(samples) == 8
    with pytest.raises(UsageError, match=r"none of 500 nm\. It has: 351, 900"):
        brdfit.read_samples(path, wavelength=500)
    with pytest.raises(UsageError, match="found 'red'"):
        brdfit.read_samples(path, wavelength="red")


def test_a_broken_row_is_kept_and_flagged(tmp_path: Path) -> None:
    rows = block(0.351)
    rows[3] = rows[3].replace("-31", "-3l")
    with pytest.warns(DataQualityWarning, match="1 unreadable, rows 5"):
        samples = brdfit.read_samples(write(tmp_path, rows))
    assert len(samples) == 8
    assert samples.bits[-1] & Flag.UNREADABLE


def test_a_header_alone_is_corrupt(tmp_path: Path) -> None:
    with pytest.raises(CorruptFile, match="no row of measurements"):
        brdfit.read_samples(write(tmp_path, []))
    with pytest.raises(CorruptFile, match="none of 1 rows"):
        brdfit.read_samples(write(tmp_path, ["a,b,c"]))


def test_nist_ptfe_is_read_whole(shared_data: Path) -> None:
    samples = brdfit.read_samples(shared_data / "nist" / "PTFE.data.csv")
    assert samples.value.shape == (1824, 4)
    assert samples.flag_counts() == {}
    assert samples.wavelengths is not None
    assert samples.wavelengths.tolist() == [351.0, 532.0, 633.0, 1064.0]
    # sintered PTFE is nearly a perfect diffuser
    np.testing.assert_allclose(np.median(samples.value, axis=0), 1 / np.pi, rtol=0.1)
