"""Delimited text and Parquet: declared columns, guesses, and rows that cannot be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import brdfit
from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile, DataQualityWarning, UnknownFormat, UsageError
from brdfit.formats.declaration import Declaration
from brdfit.geometry import (
    directions_from_half_diff,
    directions_from_spherical,
    half_diff_from_directions,
    spherical_from_directions,
)
from brdfit.samples import Flag

N = 12
SPHERICAL = ["a", "b", "c", "d"]


@pytest.fixture
def pairs(random_directions: Any) -> tuple[FloatArray, FloatArray]:
    wi, wo = random_directions(N)
    return wi, wo


def angles_of(wi: FloatArray, wo: FloatArray) -> FloatArray:
    return np.stack([*spherical_from_directions(wi), *spherical_from_directions(wo)], axis=1)


def write_csv(path: Path, names: list[str], cells: FloatArray, delimiter: str = ",") -> Path:
    lines = [delimiter.join(names)] if names else []
    lines += [delimiter.join(repr(float(cell)) for cell in row) for row in cells]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_parquet(path: Path, names: list[str], cells: FloatArray) -> Path:
    pq.write_table(pa.table(dict(zip(names, cells.T, strict=True))), path)
    return path


WRITERS = {"csv": write_csv, "parquet": write_parquet}


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("unit", ["degrees", "radians"])
def test_spherical_angles_are_read_in_the_declared_unit(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray], kind: str, unit: str
) -> None:
    wi, wo = pairs
    angles = angles_of(wi, wo)
    cells = np.column_stack([np.rad2deg(angles) if unit == "degrees" else angles, np.arange(N) + 1])
    path = WRITERS[kind](tmp_path / f"x.{kind}", [*SPHERICAL, "v"], cells)
    samples = brdfit.read_samples(path, directions=SPHERICAL, values=["v"], angles=unit)
    np.testing.assert_allclose(samples.wi, wi, atol=1e-12)
    np.testing.assert_allclose(samples.wo, wo, atol=1e-12)
    np.testing.assert_array_equal(samples.value[:, 0], np.arange(N) + 1)
    assert unit in samples.source.convention


def test_half_and_difference_angles_are_read(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray]
) -> None:
    half_diff = np.stack(half_diff_from_directions(*pairs), axis=1)
    path = write_csv(tmp_path / "x.csv", [], np.column_stack([half_diff, np.ones(N)]))
    samples = brdfit.read_samples(path, directions=[1, 2, 3], values=[4], angles="radians")
    wi, wo = directions_from_half_diff(*half_diff.T)
    np.testing.assert_allclose(samples.wi, wi, atol=1e-12)
    np.testing.assert_allclose(samples.wo, wo, atol=1e-12)


def test_relative_azimuth_and_a_constant_light_are_read(tmp_path: Path) -> None:
    theta, phi = np.linspace(1, 80, N), np.linspace(-170, 180, N)
    path = write_csv(tmp_path / "x.csv", ["t", "p", "v"], np.column_stack([theta, phi, theta]))
    samples = brdfit.read_samples(
        path,
        directions=["=30", "t", "p"],
        coordinates="relative",
        values="v",
        angles="degrees",
    )
    light = directions_from_spherical(np.deg2rad(np.full(N, 30.0)), np.zeros(N))
    np.testing.assert_allclose(samples.wi, light, atol=1e-12)
    wo = directions_from_spherical(np.deg2rad(theta), np.deg2rad(phi))
    np.testing.assert_allclose(samples.wo, wo, atol=1e-12)


def test_the_light_may_be_the_second_direction(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray]
) -> None:
    wi, wo = pairs
    path = write_csv(tmp_path / "x.csv", [], np.column_stack([wi, wo, np.ones(N)]))
    declared = {"directions": "1,2,3,4,5,6", "values": "7"}
    first = brdfit.read_samples(path, **declared)
    second = brdfit.read_samples(path, **declared, light="second")
    np.testing.assert_array_equal(first.wi, second.wo)
    np.testing.assert_array_equal(first.wo, second.wi)


@pytest.mark.parametrize("light", ["first", "second"])
def test_cosine_weighted_values_are_divided_by_the_cosine_of_the_detector(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray], light: str
) -> None:
    wi, wo = pairs
    detector = wo if light == "first" else wi
    cells = np.column_stack([wi, wo, 0.3 * detector[:, 2], 0.1 * detector[:, 2]])
    samples = brdfit.read_samples(
        write_csv(tmp_path / "x.csv", [], cells),
        directions=[1, 2, 3, 4, 5, 6],
        values=[7],
        sigma=[8],
        light=light,
        cosine_weighted="yes",
    )
    np.testing.assert_allclose(samples.value, 0.3)
    assert samples.sigma is not None
    np.testing.assert_allclose(samples.sigma, 0.1)


def test_below_the_horizon_values_are_flagged_and_not_divided(tmp_path: Path) -> None:
    cells = np.tile([0.0, 0.0, 1.0, 0.0, 0.6, 0.8, 0.4], (N, 1))
    cells[0, 5] = -0.8
    with pytest.warns(DataQualityWarning, match="1 below_horizon, rows 1"):
        samples = brdfit.read_samples(
            write_csv(tmp_path / "x.csv", [], cells),
            directions=[1, 2, 3, 4, 5, 6],
            values=[7],
            cosine_weighted=True,
        )
    assert samples.value[0, 0] == 0.4
    np.testing.assert_allclose(samples.value[1:], 0.5)


def test_a_sidecar_declares_and_options_win(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray]
) -> None:
    cells = np.column_stack([angles_of(*pairs), np.ones(N), np.full(N, 2.0)])
    path = write_csv(tmp_path / "scan.csv", [*SPHERICAL, "400", "500nm"], cells)
    (tmp_path / "scan.toml").write_text('angles = "degrees"\n')
    (tmp_path / "scan.csv.toml").write_text(
        'directions = ["a", "b", "c", "d"]\nvalues = ["400", "500nm"]\nangles = "radians"\n'
    )
    samples = brdfit.read_samples(path)
    assert samples.source.notes == ("columns declared in scan.csv.toml",)
    assert samples.wavelengths is not None
    assert samples.wavelengths.tolist() == [400.0, 500.0]
    assert samples.channels == ("400nm", "500nm")
    other = brdfit.read_samples(path, values=["500nm"])
    assert other.value.tolist() == [[2.0]] * N


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("directions = [", "not valid TOML"),
        ('directons = ["a"]', "Did you mean 'directions'"),
        ('directions = ["a", "b", "c", "d"]', "the columns are not clear"),
        ('directions = ["a", "b"]\nvalues = ["v"]', "found 2 columns"),
        ('directions = ["a", "b", "c", "d"]\nvalues = ["v"]', "angles: must be declared"),
        ('directions = ["a","b","c","x"]\nvalues = ["v"]\nangles = "radians"', "no column 'x'"),
        ('directions = ["a","b","c","d"]\nvalues = [9]\nangles = "radians"', "columns are 1 to 5"),
        ('directions = ["a","b","c","d"]\nvalues = ["v"]\nangles = "grad"', "found 'grad'"),
        ('directions = ["a","b","c","d"]\nvalues = ["v"]\ncosine_weighted = "si"', "true or false"),
    ],
)
def test_a_wrong_declaration_says_what_is_wrong(tmp_path: Path, text: str, said: str) -> None:
    path = write_csv(tmp_path / "x.csv", [*SPHERICAL, "v"], np.full((N, 5), 0.5))
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(UsageError) as caught:
        brdfit.read_samples(path)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "names",
    [
        ["theta_i_deg", "phi_i_deg", "theta_o_deg", "phi_o_deg"],
        ["thetai [deg]", "phii [deg]", "thetar [deg]", "phir [deg]"],
        ["Theta In", "Phi In", "Theta Out", "Phi Out"],
        ["theta-inc", "phi-inc", "theta-s", "phi-s"],
    ],
)
def test_columns_are_guessed_from_their_names_and_it_is_said(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray], names: list[str]
) -> None:
    cells = np.column_stack([np.rad2deg(angles_of(*pairs)), np.ones((N, 3)), np.zeros(N)])
    path = write_csv(tmp_path / "x.csv", [*names, "r", "g", "b", "weather"], cells)
    samples = brdfit.read_samples(path)
    np.testing.assert_allclose(samples.wi, pairs[0], atol=1e-12)
    np.testing.assert_allclose(samples.wo, pairs[1], atol=1e-12)
    assert samples.channels == ("R", "G", "B")
    notes = "\n".join(samples.source.notes)
    assert "columns guessed" in notes
    assert "columns not read: weather" in notes
    assert "degrees" in notes


@pytest.mark.parametrize("kind", WRITERS)
def test_small_angles_without_a_unit_are_not_guessed(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray], kind: str
) -> None:
    names = ["theta_i", "phi_i", "theta_o", "phi_o", "brdf"]
    cells = np.column_stack([angles_of(*pairs), np.ones(N)])
    cells[0, 1] = 999.0  # one wild number is no evidence
    path = WRITERS[kind](tmp_path / f"x.{kind}", names, cells)
    with pytest.raises(UsageError) as caught:
        brdfit.read_samples(path)
    assert 'directions = ["theta_i", "phi_i", "theta_o", "phi_o"]' in str(caught.value)
    assert f"x.{kind}.toml" in str(caught.value)
    assert len(brdfit.read_samples(path, angles="radians")) == N


@pytest.mark.parametrize(
    ("names", "why"),
    [
        (["theta_i", "phi_i", "theta_o", "azimuth", "fr"], "no complete set"),
        (["theta_i", "phi_i", "theta_o", "phi_o", "counts"], "no column is named as a value"),
        (["theta_i", "phi_i", "theta_o", "phi_o", "fr", "400nm"], "several columns"),
        (["theta_i", "theta_in", "phi_i", "theta_o", "phi_o", "fr"], "more than one column"),
        (["theta_i", "theta_i", "phi_i", "theta_o", "phi_o", "fr"], "same name"),
    ],
)
def test_unclear_names_give_the_sidecar_to_write(
    tmp_path: Path, names: list[str], why: str
) -> None:
    path = write_csv(tmp_path / "x.csv", names, np.full((N, len(names)), 20.0))
    with pytest.raises(UsageError, match=why) as caught:
        brdfit.read_samples(path)
    assert "angles = " in str(caught.value)


def test_what_is_declared_is_not_guessed(
    tmp_path: Path, pairs: tuple[FloatArray, FloatArray]
) -> None:
    cells = np.column_stack([*pairs, np.full(N, 7.0), np.full(N, 8.0)])
    names = ["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z", "counts", "brdf"]
    path = write_csv(tmp_path / "x.csv", names, cells)
    assert brdfit.read_samples(path, values=["counts"]).value.tolist() == [[7.0]] * N
    other_way = brdfit.read_samples(path, directions=[4, 5, 6, 1, 2, 3])
    assert other_way.value.tolist() == [[8.0]] * N
    np.testing.assert_array_equal(other_way.wi, pairs[1])
    assert other_way.source.notes[0] == "columns guessed from their names: values from brdf"


def test_the_sidecar_of_the_error_is_valid_toml(tmp_path: Path) -> None:
    names = ["theta_i", "phi_i", "theta_o", "phi_o", "fr"]
    path = write_csv(tmp_path / "x.csv", names, np.full((N, 5), 0.5))
    with pytest.raises(UsageError) as caught:
        brdfit.read_samples(path)
    (tmp_path / "x.csv.toml").write_text(str(caught.value).split("\n\n", 1)[1])
    samples = brdfit.read_samples(path, angles="radians")
    assert len(samples) == N


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " ", "  "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_delimiters_line_ends_and_byte_order_marks_change_nothing(
    tmp_path: Path, delimiter: str, end: str, mark: bytes
) -> None:
    lines = ["# a comment", "", delimiter.join(["theta_h_rad", "theta_d", "phi_d", "fr"])]
    lines += [delimiter.join([f"0.{row}", "0.2", "1e0", "+.5"]) for row in range(1, N)]
    path = tmp_path / "x.txt"
    path.write_bytes(mark + end.join(lines).encode())
    samples = brdfit.read_samples(path)
    assert samples.value.tolist() == [[0.5]] * (N - 1)
    assert samples.rows is not None
    assert samples.rows.tolist() == list(range(4, N + 3))


def test_decimal_commas_are_understood_between_semicolons(tmp_path: Path) -> None:
    rows = [f"{row},5;0;20,25;180;0,{row:02}" for row in range(10, 30)]
    path = tmp_path / "x.csv"
    path.write_text("theta_i;phi_i;theta_o;phi_o;fr\n" + "\n".join(rows))
    samples = brdfit.read_samples(path)
    assert samples.value[:3, 0].tolist() == [0.10, 0.11, 0.12]
    assert "decimal commas recognised" in samples.source.notes


def test_utf16_and_latin1_text_is_read(tmp_path: Path) -> None:
    text = "# 20 °C\ntheta_i_deg,phi_i,theta_o,phi_o,fr\n" + "10,0,20,180,0.5\n" * N
    for name, encoding in (("a.csv", "utf-16"), ("b.csv", "latin-1")):
        (tmp_path / name).write_bytes(text.encode(encoding))
        assert len(brdfit.read_samples(tmp_path / name)) == N


def test_names_in_the_last_comment_are_the_header(tmp_path: Path) -> None:
    path = tmp_path / "x.txt"
    path.write_text("# made today\n# theta_h_rad theta_d phi_d value\n" + "0.1 0.2 0.3 0.4\n" * N)
    samples = brdfit.read_samples(path)
    assert samples.channels == ("value",)
    assert len(samples) == N


BROKEN = {
    "too few fields": "0.1,0.2,0.3",
    "too many fields": "0.1,0.2,0.3,0.4,0.5",
    "a word": "0.1,0.2,banana,0.4",
    "two points": "0.1,0.2,0.3.1,0.4",
    "an underscore": "0.1,0.2,0.3,1_0",
    "an open quote": '0.1,0.2,0.3,"0.4',
    "binary": "\x01\x02\x7f",
    "a very long line": "9" * 100_000 + "," + "x" * 100_000,
}


@pytest.mark.parametrize("broken", BROKEN.values(), ids=BROKEN)
def test_a_row_that_cannot_be_read_keeps_its_place_and_number(tmp_path: Path, broken: str) -> None:
    good = [f"0.{row},0.2,0.3,0.4" for row in range(10, 30)]
    lines = ["theta_h,theta_d,phi_d,fr", *good[:7], "", "# note", broken, *good[7:]]
    path = tmp_path / "x.csv"
    path.write_text("\n".join(lines))
    with pytest.warns(DataQualityWarning, match="1 unreadable, rows 11"):
        samples = brdfit.read_samples(path, angles="radians")
    assert len(samples) == 21
    assert samples.rows is not None
    (bad,) = np.flatnonzero(samples.bits & Flag.UNREADABLE)
    assert samples.rows[bad] == 11
    assert np.isnan(samples.value[bad]).all()
    good_value = np.delete(samples.value[:, 0], bad)
    assert (good_value == 0.4).all()
    assert "rows that could not be read: 1 (lines 11)" in samples.source.notes


def test_text_in_a_column_that_is_not_used_does_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("theta_h,theta_d,phi_d,fr,who\n" + '0.1,0.2,0.3,0.4,"Ann, Bo"\n' * N)
    assert brdfit.read_samples(path, angles="radians").flag_counts() == {"duplicate": N - 1}


def test_missing_cells_are_missing_values_and_not_unreadable(tmp_path: Path) -> None:
    rows = ["0.1,0.2,0.3,,0.4", "0.2,0.2,0.3,NaN,n/a", "0.3,0.2,0.3,-0.1,0"]
    rows += [f"0.{row},0.2,0.3,1,2" for row in range(40, 60)]
    path = tmp_path / "x.csv"
    path.write_text("theta_h,theta_d,phi_d,400nm,500nm\n" + "\n".join(rows))
    with pytest.warns(DataQualityWarning, match="1 not_finite, rows 3"):
        samples = brdfit.read_samples(path, angles="radians")
    assert samples.flag_counts() == {"not_finite": 1, "partly_missing": 1, "censored": 1}
    assert samples.value[2].tolist() == [-0.1, 0.0]


def test_a_flag_column_rejects_rows(tmp_path: Path) -> None:
    rows = [f"0.{row},0.2,0.3,1,{int(row == 15)}" for row in range(10, 30)]
    path = tmp_path / "x.csv"
    path.write_text("theta_h,theta_d,phi_d,fr,bad\n" + "\n".join(rows))
    samples = brdfit.read_samples(path, angles="radians", flags="bad")
    assert samples.flag_counts() == {"rejected": 1}
    assert not samples.usable[5, 0]


def test_no_readable_row_at_all_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("theta_h,theta_d,phi_d,fr\n" + "0.1,0.2,0.3,low\n" * 4)
    with pytest.raises(CorruptFile, match="none of 4 rows"):
        brdfit.read_samples(path, format="delimited", angles="radians")


def test_a_header_that_does_not_fit_the_rows_is_told(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("theta_h,theta_d,phi_d\n" + "0.1,0.2,0.3,0.4\n" * 4)
    with pytest.raises(UnknownFormat, match="header names 3 columns but the rows have 4"):
        brdfit.read_samples(path)


def test_a_damaged_first_row_is_not_taken_for_a_header(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("0.1,oops,0.3,0.4\n" + "0.1,0.2,0.3,0.4\n" * N)
    with pytest.warns(DataQualityWarning, match="1 unreadable, rows 1"):
        samples = brdfit.read_samples(path, directions=[1, 2, 3], values=[4], angles="radians")
    assert len(samples) == N + 1


def test_a_declaration_checks_itself() -> None:
    with pytest.raises(UsageError, match="wavelengths: found 1 for 2"):
        Declaration(directions=(1, 2, 3, 4, 5, 6), values=(7, 8), wavelengths=(400.0,))
    with pytest.raises(UsageError, match="sigma: found 3"):
        Declaration(directions=(1, 2, 3, 4, 5, 6), values=(7, 8), sigma=(1, 2, 3))
    with pytest.raises(UsageError, match="values: found no column"):
        Declaration(directions=(1, 2, 3, 4, 5, 6), values=())
    with pytest.raises(UsageError, match="light: found 'i'"):
        Declaration(directions=(1, 2, 3, 4, 5, 6), values=(7,), light="i")


def test_a_wavelength_with_a_fraction_is_a_wavelength(tmp_path: Path) -> None:
    rows = "".join(f"0.{k},0,0.{k},3,1,2,3\n" for k in range(10, 22))
    path = tmp_path / "a.csv"
    path.write_text(f"theta.i,phi.i,theta.o,phi.o,400.25nm,632.8 nm,1064.1nm\n{rows}")
    samples = brdfit.read_samples(path, angles="radians")
    assert samples.wavelengths is not None
    assert samples.wavelengths.tolist() == [400.25, 632.8, 1064.1]
