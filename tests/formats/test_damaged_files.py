"""Whatever a file holds: a result, a project error, a project warning; nothing foreign."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import brdfit
from brdfit.errors import BrdfitError, BrdfitWarning

ASTM = (
    "LAB_NAME A\nSAMPLE_NAME B\nNUM_POINTS 12\nVARS theta_i,phi_i,theta_s,phi_s,400nm,500nm\n\n"
    + "".join(f"0.{k},0.0,0.{k},3.14,0.5,{k}.25\n" for k in range(10, 22))
)
NIST = "lambda,thetai,phi,thetar,phir,f_r11,f_r12/f_r11\n" + "".join(
    f"0.{w},-{t},0,{t},20.5,3.1E-01,0.02\n" for w in (351, 532) for t in range(5, 17)
)
CURET = "1  " + " ".join(f"0.{k:03}" for k in range(205)) + "\n"
ALTA = "#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n" + "".join(f"0.{k} 0.2 0.3 1\n" for k in range(9, 21))
PLAIN = "theta_i_deg;phi_i;theta_o;phi_o;r;g;b;sigma\n" + "".join(
    f"{k};0,5;{k + 3};-170;0,1;0,2;0,3;x\n" for k in range(20, 34)
)
OWN = (
    '# brdfit samples {"version": 1, "channels": ["value"], "wavelengths": null, "sigma": false, '
    '"rows": true, "source": {"name": "a", "format": "b", "sha256": "", "convention": "", '
    '"notes": [], "metadata": {}}}\nwi_x,wi_y,wi_z,wo_x,wo_y,wo_z,value,brdfit_flags,brdfit_row\n'
    + "0.0,0.0,1.0,0.0,0.6,0.8,0.5,0,7\n"
    * 12
)
WHOLE = {
    "astm": ASTM,
    "nist": NIST,
    "curet": CURET,
    "alta": ALTA,
    "delimited": PLAIN,
    "own": OWN,
}
NAMES = ("astm", "nist", "curet", "alta", "delimited", "parquet")


def read_or_say(path: Path, format: str | None = None) -> brdfit.Samples | None:
    """Read; None where a project error says why not. Anything else fails the test."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", BrdfitWarning)
        try:
            return brdfit.read_samples(path, format=format)
        except BrdfitError as error:
            said = str(error)
    assert len(said) > 20
    return None


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("damaged")
    rows = np.random.default_rng(0).uniform(0, 1.4, (205, 4))
    lines = (f"{k + 1} " + " ".join(map(str, row)) for k, row in enumerate(rows))
    (folder / "table.txt").write_text("\n".join(lines))
    return folder


@pytest.mark.parametrize("name", WHOLE)
def test_the_whole_files_are_read_by_sniffing(folder: Path, name: str) -> None:
    path = folder / "whole.dat"
    path.write_text(WHOLE[name])
    samples = read_or_say(path)
    assert samples is not None
    assert samples.source.format == ("delimited" if name == "own" else name)
    assert samples.usable.all()


@pytest.mark.parametrize("name", WHOLE)
@given(data=st.data())
@settings(max_examples=40)
def test_a_file_cut_anywhere_gives_a_result_or_says_why_not(
    folder: Path, name: str, data: st.DataObject
) -> None:
    content = WHOLE[name].encode()
    path = folder / "cut.dat"
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    read_or_say(path)


@pytest.mark.parametrize("name", WHOLE)
@given(data=st.data())
@settings(max_examples=60)
def test_altered_bytes_give_a_result_or_say_why_not(
    folder: Path, name: str, data: st.DataObject
) -> None:
    content = bytearray(WHOLE[name].encode())
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place : place + 1] = data.draw(
            st.sampled_from([b"", b"\n", b",", b"\0", b'"', b"#", b"-", b"e9999", b"nan", b"\xff"])
        )
    path = folder / "altered.dat"
    path.write_bytes(bytes(content))
    read_or_say(path)


@given(content=st.binary(min_size=1, max_size=300), name=st.sampled_from([None, *NAMES]))
@example(content=b"PAR1", name=None)
@example(content=b"\xff\xfe\x00", name="delimited")
@example(content=b"\xef\xbb\xbf", name="delimited")
@example(content=b"0 0 0 0\n" * 3, name="delimited")
@example(content=b'"', name="nist")
@example(content=b"VARS", name="astm")
@example(content=b"#DIM 99999999999999999999 1\n1", name="alta")
@settings(max_examples=300)
def test_garbage_gives_a_result_or_says_why_not(
    folder: Path, content: bytes, name: str | None
) -> None:
    path = folder / "garbage.dat"
    path.write_bytes(content)
    read_or_say(path, name)


@given(
    rows=st.lists(
        st.lists(
            st.sampled_from(["0.1", "1e-3", "-2", "", "nan", "x", "inf", '"', "1e400"]),
            min_size=3,
            max_size=6,
        ),
        min_size=1,
        max_size=12,
    )
)
def test_every_row_of_a_table_becomes_a_sample(folder: Path, rows: list[list[str]]) -> None:
    path = folder / "rows.csv"
    good = ["0.5", "0.4", "0.3", "0.2"]
    filled = [good, good, *rows, good, *([good] * len(rows))]
    path.write_text("theta_h,theta_d,phi_d,fr\n" + "\n".join(",".join(row) for row in filled))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        samples = brdfit.read_samples(path, angles="radians")
    assert samples.rows is not None
    assert samples.rows.tolist() == list(range(2, len(filled) + 2))
    numbers = {"0.1", "1e-3", "-2", "0.2", "inf", "1e400", "nan", ""}
    for row, flags in zip(filled, samples.bits, strict=True):
        trimmed = row[:4] + [cell for cell in row[4:] if cell]
        well_formed = len(trimmed) == 4 and set(row[:4]) <= numbers | set(good)
        assert bool(flags & 64) != well_formed, row


def test_very_long_lines_are_no_trouble(folder: Path) -> None:
    path = folder / "long.csv"
    path.write_text(",".join(["1"] * 100_000) + "\n" + "9" * 100_000 + "x\n")
    assert read_or_say(path) is None
