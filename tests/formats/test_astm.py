"""ASTM E1392 as Cornell wrote it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, DataQualityWarning, UnknownFormat, UsageError
from brdfit.geometry import half_diff_from_directions
from brdfit.samples import Flag, Source

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


def test_what_was_read_is_written_and_read_again(shared_data: Path, tmp_path: Path) -> None:
    first = brdfit.read_samples(shared_data / "cornell" / "krylon_blue.astm")
    path = tmp_path / "again.astm"
    brdfit.write_samples(first, path)
    again = brdfit.read_samples(path)
    np.testing.assert_array_equal(again.value, first.value)
    np.testing.assert_allclose(again.wi, first.wi, atol=1e-12)
    np.testing.assert_allclose(again.wo, first.wo, atol=1e-12)
    assert again.wavelengths is not None
    np.testing.assert_array_equal(again.wavelengths, first.wavelengths)
    assert again.source.metadata == first.source.metadata


def samples_of(**more: object) -> brdfit.Samples:
    rng = np.random.default_rng(4)
    wi = brdfit.directions_from_spherical(rng.uniform(0.1, 1.2, 14), rng.uniform(-3, 3, 14))
    wo = brdfit.directions_from_spherical(rng.uniform(0.1, 1.2, 14), rng.uniform(-3, 3, 14))
    value = rng.uniform(0.1, 1.0, (14, 2))
    return brdfit.Samples(wi=wi, wo=wo, value=value, **more)


def test_deviations_gaps_and_odd_wavelengths_are_kept(tmp_path: Path) -> None:
    samples = samples_of(sigma=np.full((14, 2), 0.01), wavelengths=np.array([400.25, 1064.1]))
    value = samples.value.copy()
    value[3, 1], value[4, 0] = np.nan, -0.25
    samples = samples.with_value(value)
    brdfit.write_samples(samples, tmp_path / "a.astm")
    back = brdfit.read_samples(tmp_path / "a.astm")
    np.testing.assert_array_equal(back.value, samples.value)
    np.testing.assert_array_equal(back.sigma, samples.sigma)
    np.testing.assert_array_equal(back.wavelengths, samples.wavelengths)


def test_what_was_rejected_does_not_come_back_as_good(tmp_path: Path) -> None:
    samples = samples_of(wavelengths=np.array([400.0, 500.0]))
    marked = samples.with_flags(np.arange(14) < 3, Flag.REJECTED)
    with pytest.warns(DataQualityWarning, match="3 of 14 samples .* left out"):
        brdfit.write_samples(marked, tmp_path / "a.astm")
    back = brdfit.read_samples(tmp_path / "a.astm")
    np.testing.assert_array_equal(back.value, samples.value[3:])
    with pytest.raises(UsageError, match="all 14 samples are marked"):
        brdfit.write_samples(
            samples.with_flags(np.ones(14, bool), Flag.REJECTED), tmp_path / "b.astm"
        )


@pytest.mark.parametrize("names", [("left", "right"), ("R", "G"), ("400", "a,b"), ("R", "R")])
def test_channels_that_could_not_be_read_again_are_refused(
    names: tuple[str, str], tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=r"names that ASTM E1392 could not be read by"):
        brdfit.write_samples(samples_of(channels=names), tmp_path / "a.astm")


def test_where_samples_came_from_is_said(tmp_path: Path) -> None:
    source = Source(name="a b.csv", format="delimited", sha256="f00")
    samples = samples_of(wavelengths=np.array([400.0, 500.0]), source=source)
    brdfit.write_samples(samples, tmp_path / "a.astm")
    fields = brdfit.read_samples(tmp_path / "a.astm").source.metadata
    assert fields["LAB_COMMENTS"] == "written by brdfit from a b.csv (delimited), SHA-256 f00"
    assert fields["SAMPLE_NAME"] == "a b"
