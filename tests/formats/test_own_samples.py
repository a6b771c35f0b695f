"""Our own CSV and Parquet of samples bring back every bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import brdfit
from brdfit.arrays import FloatArray
from brdfit.errors import BrdfitWarning, CorruptFile, DataQualityWarning
from brdfit.formats.delimited import SHEET as CSV
from brdfit.formats.parquet import SHEET as PARQUET
from brdfit.formats.sheet import FormatSheet
from brdfit.samples import Flag, Samples, Source

SHEETS = pytest.mark.parametrize("sheet", [CSV, PARQUET], ids=["csv", "parquet"])

ANY = st.floats(width=64, allow_nan=True, allow_infinity=True)


def there_and_back(samples: Samples, sheet: FormatSheet, path: Path) -> Samples:
    assert sheet.write_samples is not None
    assert sheet.read_samples is not None
    sheet.write_samples(samples, path)
    return sheet.read_samples(path)


def assert_same(a: Samples, b: Samples) -> None:
    for name in ("wi", "wo", "value", "sigma", "wavelengths", "flags", "rows"):
        x, y = getattr(a, name), getattr(b, name)
        assert (x is None) == (y is None), name
        if x is not None:
            np.testing.assert_array_equal(x, y, err_msg=name)
            assert x.dtype == y.dtype
            assert (np.signbit(x) == np.signbit(y)).all() or np.isnan(x).any()
    assert a.channels == b.channels


@SHEETS
@given(data=st.data())
@settings(max_examples=40)
def test_any_samples_come_back_exactly(
    sheet: FormatSheet, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    n, channels = data.draw(st.integers(1, 6)), data.draw(st.integers(1, 4))

    def draw(*shape: int) -> FloatArray:
        return data.draw(hnp.arrays(np.float64, shape, elements=ANY))

    names = st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=5)
    with_waves = data.draw(st.booleans())
    samples = Samples(
        wi=draw(n, 3),
        wo=draw(n, 3),
        value=draw(n, channels),
        sigma=draw(n, channels) if data.draw(st.booleans()) else None,
        wavelengths=np.linspace(400, 700, channels) / 3 if with_waves else None,
        channels=tuple(data.draw(st.lists(names, min_size=channels, max_size=channels))),
        flags=data.draw(hnp.arrays(np.int64, n, elements=st.integers(0, 255))),
        rows=np.arange(n) * 7 + 3 if data.draw(st.booleans()) else None,
    )
    folder = tmp_path_factory.mktemp("own")
    assert_same(samples, there_and_back(samples, sheet, folder / f"x{sheet.extensions[0]}"))


@SHEETS
def test_the_origin_travels_along(sheet: FormatSheet, tmp_path: Path) -> None:
    source = Source("first.astm", "astm", "ab12", "radians", ("a note",), {"LAB": 'x, "y"\nz'})
    wi = np.tile([0.0, 0.0, 1.0], (3, 1))
    samples = Samples(wi=wi, wo=wi, value=np.ones(3), source=source)
    back = there_and_back(samples, sheet, tmp_path / "x").source
    assert back.name == "x"
    assert back.format == sheet.name
    assert len(back.sha256) == 64
    assert back.convention == "radians"
    assert back.notes == ("a note",)
    assert back.metadata["LAB"] == 'x, "y"\nz'
    assert back.metadata["origin.name"] == "first.astm"
    assert back.metadata["origin.sha256"] == "ab12"


@SHEETS
def test_flags_given_and_found_survive_the_front_door(sheet: FormatSheet, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    w = rng.normal(size=(40, 3))
    w[:, 2] = np.abs(w[:, 2]) + 0.2
    w /= np.linalg.norm(w, axis=1)[:, None]
    value = rng.uniform(0.1, 1, (40, 2))
    value[3], value[4, 0], value[5, 1] = np.nan, np.nan, -1.0
    samples = Samples(wi=w, wo=w[::-1], value=value, rows=np.arange(40) + 9)
    samples = samples.with_flags(np.arange(40) == 7, Flag.REJECTED)
    path = tmp_path / f"x{sheet.extensions[0]}"
    brdfit.write_samples(samples, path)
    with pytest.warns(BrdfitWarning):
        back = brdfit.read_samples(path)
    assert_same(samples, back)


def test_our_csv_without_its_first_line_is_still_unambiguous(tmp_path: Path) -> None:
    wi = np.tile([0.0, 0.6, 0.8], (12, 1))
    samples = Samples(
        wi=wi,
        wo=wi,
        value=np.linspace(-1, 1, 24).reshape(12, 2),
        sigma=np.ones((12, 2)),
        wavelengths=np.array([450.0, 550.0]),
        rows=np.arange(12),
    ).with_flags(np.arange(12) == 2, Flag.REJECTED)
    brdfit.write_samples(samples, tmp_path / "x.csv")
    lines = (tmp_path / "x.csv").read_text().splitlines(keepends=True)
    (tmp_path / "y.csv").write_text("".join(lines[1:]))
    back = brdfit.read_samples(tmp_path / "y.csv")
    for name in ("wi", "wo", "value", "sigma", "wavelengths", "flags"):
        np.testing.assert_array_equal(getattr(samples, name), getattr(back, name))
    assert back.channels == samples.channels


def test_a_damaged_row_of_our_csv_is_flagged(tmp_path: Path) -> None:
    wi = np.tile([0.0, 0.6, 0.8], (12, 1))
    brdfit.write_samples(Samples(wi=wi, wo=wi, value=np.ones(12)), tmp_path / "x.csv")
    lines = (tmp_path / "x.csv").read_text().splitlines()
    lines[4] = lines[4].replace("0.6", "O.6", 1)
    (tmp_path / "x.csv").write_text("\n".join(lines))
    with pytest.warns(DataQualityWarning, match="1 unreadable"):
        back = brdfit.read_samples(tmp_path / "x.csv")
    assert len(back) == 12
    assert "rows that could not be read: 1 (lines 5)" in back.source.notes


@pytest.mark.parametrize("header", ["{", "{}", "[]", "null", '{"version": 99}'])
def test_a_damaged_header_of_our_csv_is_corrupt(tmp_path: Path, header: str) -> None:
    path = tmp_path / "x.csv"
    path.write_text(f"# brdfit samples {header}\nwi_x\n1\n")
    with pytest.raises(CorruptFile, match="header of a brdfit samples file"):
        brdfit.read_samples(path)


def test_nothing_is_left_where_writing_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import pyarrow.csv

    def fail(*args: object, **kwargs: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(pyarrow.csv, "write_csv", fail)
    wi = np.array([[0.0, 0.0, 1.0]])
    with pytest.raises(brdfit.BrdfitError, match="No space left"):
        brdfit.write_samples(Samples(wi=wi, wo=wi, value=np.ones(1)), tmp_path / "x.csv")
    assert list(tmp_path.iterdir()) == []
