"""The front door: which format is asked, and what is said when none answers."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import (
    CorruptFile,
    DataQualityWarning,
    FormatError,
    UnknownFormat,
    UsageError,
)
from brdfit.formats import _registry

ROWS = "".join(f"{a / 10},0.1,{a / 12},3.0,0.{a}\n" for a in range(1, 13))
GOOD = "theta_i_rad,phi_i_rad,theta_o_rad,phi_o_rad,fr\n" + ROWS


def write(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_content_decides_and_the_suffix_does_not(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path, "measured.binary", GOOD))
    assert samples.source.format == "delimited"
    assert samples.source.name == "measured.binary"


def test_a_particular_format_goes_before_plain_text_whatever_the_suffix(tmp_path: Path) -> None:
    header = "lambda,thetai,phi,thetar,phir,f_r11\n"
    rows = "".join(f"0.5,-{t},0,{t},9,0.3\n" for t in range(5, 17))
    for name in ("x.csv", "x.txt", "x.dat", "x"):
        samples = brdfit.read_samples(write(tmp_path, name, header + rows))
        assert samples.source.format == "nist"


def test_a_sniff_that_crashes_does_not_stop_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def crash(path: Path, head: bytes) -> bool:
        raise ZeroDivisionError("in a sniff")

    sheets = brdfit.list_formats()
    broken = (replace(sheets[0], sniff=crash), *sheets[1:])
    monkeypatch.setattr(_registry, "list_formats", lambda: broken)
    assert len(brdfit.read_samples(write(tmp_path, "good.csv", GOOD))) == 12
    with pytest.raises(UnknownFormat, match="failed while looking: ZeroDivisionError"):
        brdfit.read_samples(write(tmp_path, "bad.dat", "nothing here\n"))


def test_no_sniff_raises_and_at_most_one_claims_a_file(tmp_path: Path) -> None:
    for head in (b"", b"\0" * 50, b"\xff" * 9000, b"PK\3\4", GOOD.encode(), b"#DIM 1 3\n0 1 2 3"):
        claims = [s.name for s in brdfit.list_formats() if s.sniff(tmp_path / "x.dat", head)]
        assert len(claims) <= 2, claims


def test_what_nobody_knows_is_told_with_the_formats_tried(tmp_path: Path) -> None:
    with pytest.raises(UnknownFormat) as caught:
        brdfit.read_samples(write(tmp_path, "x.alta", "a letter to my mother\n"))
    for said in ("astm", "merl", "delimited", "suffix it should be ALTA", "x.alta.toml"):
        assert said in str(caught.value)


def test_missing_empty_and_folders_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="no such file"):
        brdfit.read_samples(tmp_path / "missing.csv")
    with pytest.raises(FormatError, match="is a folder"):
        brdfit.read_samples(tmp_path)
    with pytest.raises(FormatError, match=r"empty \(0 bytes\)"):
        brdfit.read_table(write(tmp_path, "empty.binary", b""))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads all")
def test_a_file_without_permission_is_a_format_error(tmp_path: Path) -> None:
    path = write(tmp_path, "closed.csv", GOOD)
    path.chmod(0)
    with pytest.raises(FormatError, match="cannot be read"):
        brdfit.read_samples(path)


def test_an_operating_system_error_while_reading_is_a_format_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(path: Path, **options: object) -> brdfit.Samples:
        raise OSError(5, "Input/output error")

    sheets = tuple(replace(s, read_samples=fail) for s in brdfit.list_formats())
    monkeypatch.setattr(_registry, "list_formats", lambda: sheets)
    with pytest.raises(FormatError, match="Input/output error"):
        brdfit.read_samples(write(tmp_path, "good.csv", GOOD))


def test_a_parser_that_trips_is_a_corrupt_file_and_a_defect_is_not_hidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, "good.csv", GOOD)

    def raising(error: Exception) -> None:
        def read(path: Path, **options: object) -> brdfit.Samples:
            raise error

        sheets = tuple(replace(s, read_samples=read) for s in brdfit.list_formats())
        monkeypatch.setattr(_registry, "list_formats", lambda: sheets)

    raising(IndexError("off the end"))
    with pytest.raises(CorruptFile, match="off the end"):
        brdfit.read_samples(path, format="delimited")
    raising(AttributeError("a defect"))
    with pytest.raises(AttributeError, match="a defect"):
        brdfit.read_samples(path, format="delimited")


def test_the_wrong_question_names_the_right_one(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"brdfit\.read_samples"):
        brdfit.read_table(write(tmp_path, "x.csv", GOOD))


def test_an_unknown_option_names_the_allowed_ones(tmp_path: Path) -> None:
    path = write(tmp_path, "x.csv", GOOD)
    with pytest.raises(UsageError, match=r"Did you mean 'angles'.*Allowed: directions"):
        brdfit.read_samples(path, angels="degrees")


def test_an_unknown_format_names_the_known_ones(tmp_path: Path) -> None:
    path = write(tmp_path, "x.csv", GOOD)
    with pytest.raises(UsageError, match="Did you mean 'delimited'"):
        brdfit.read_samples(path, format="delimitted")


def test_writing_goes_by_suffix_and_names_what_can_be_written(tmp_path: Path) -> None:
    samples = brdfit.read_samples(write(tmp_path, "x.csv", GOOD))
    with pytest.raises(UsageError, match=r"delimited \(\.csv"):
        brdfit.write_samples(samples, tmp_path / "out.xyz")
    with pytest.raises(UsageError, match="cannot be written as samples"):
        brdfit.write_samples(samples, tmp_path / "out.csv", format="nist")
    with pytest.raises(FormatError, match="no such folder"):
        brdfit.write_samples(samples, tmp_path / "nowhere" / "out.csv")
    with pytest.raises(FormatError, match="is a folder"):
        brdfit.write_samples(samples, tmp_path, format="delimited")
    brdfit.write_samples(samples, tmp_path / "out.xyz", format="delimited")
    assert len(brdfit.read_samples(tmp_path / "out.xyz")) == len(samples)


def test_unusable_rows_are_counted_with_their_numbers(tmp_path: Path) -> None:
    text = GOOD + "0.3,0.1,broken,3.0,0.4\n0.3,0.1,0.4,3.0,nan\n"
    with pytest.warns(DataQualityWarning, match=r"2 of 14.*1 unreadable, rows 14, 15"):
        samples = brdfit.read_samples(write(tmp_path, "x.csv", text))
    assert samples.flag_counts()["unreadable"] == 1
    assert np.isnan(samples.wi[-2]).all()


def test_three_samples_are_read_with_a_warning(tmp_path: Path) -> None:
    text = "\n".join(GOOD.splitlines()[:4])
    with pytest.warns(DataQualityWarning, match="only 3 usable"):
        samples = brdfit.read_samples(write(tmp_path, "x.csv", text))
    assert len(samples) == 3


def test_every_sheet_says_what_it_is() -> None:
    names = [sheet.name for sheet in brdfit.list_formats()]
    assert len(names) == len(set(names))
    for sheet in brdfit.list_formats():
        assert sheet.title
        assert sheet.convention
        assert sheet.specification
        assert all(e.startswith(".") and e == e.lower() for e in sheet.extensions)
        assert sheet.read_samples or sheet.read_table
