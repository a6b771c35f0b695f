"""A table as one OpenEXR picture: what a person sees in it, and what comes back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.formats.exr_file import read_exr, write_exr
from brdfit.grid import Grid
from brdfit.samples import Source
from brdfit.table import Table

from small_files import tiny_table

pytest.importorskip("OpenEXR", reason="the extra 'exr' is not installed")

GRID = Grid(4, 3, 6)


def table_of(channels: int = 3, **more: object) -> Table:
    values = np.random.default_rng(1).uniform(0.1, 2.0, (*GRID.shape, channels))
    return Table(values, grid=GRID, **more)


def test_a_slice_has_theta_h_to_the_right_and_theta_d_upward(tmp_path: Path) -> None:
    path, table = tmp_path / "a.exr", table_of()
    brdfit.write_table(table, path)
    planes, _ = read_exr(path)
    # six slices of 4 x 3 pixels: three beside one another make the picture about square
    assert sorted(planes) == ["B", "G", "R"]
    assert planes["R"].shape == (9, 8)
    i, j, k = 1, 1, 3
    row, column = divmod(k, 2)
    pixel = planes["G"][row * 3 + (2 - j), column * 4 + i]
    assert pixel == np.float32(table.values[i, j, k, 1])


def test_cells_without_a_measurement_are_not_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    valid = np.ones(GRID.shape, dtype=bool)
    valid[0, 0, 2] = False
    table = table_of(valid=valid)
    brdfit.write_table(table, path)
    planes, _ = read_exr(path)
    assert np.isnan(planes["R"]).sum() == GRID.size - table.mask.sum()
    np.testing.assert_array_equal(brdfit.read_table(path).mask, table.mask)


def test_wavelengths_names_and_origin_come_back(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    source = Source(name="x.astm", format="astm", sha256="ab", notes=("n",), metadata={"k": "v"})
    waves = np.array([400.5, 550.0, 610.25, 700.0])
    brdfit.write_table(table_of(4, wavelengths=waves, source=source), path)
    back = brdfit.read_table(path)
    assert back.wavelengths is not None
    np.testing.assert_array_equal(back.wavelengths, waves)
    assert sorted(read_exr(path)[0])[0] == "400,5nm"
    assert (back.source.name, back.source.format) == ("a.exr", "exr")
    assert back.source.notes == ("n",)
    assert back.source.metadata["origin.name"] == "x.astm"
    assert back.source.metadata["k"] == "v"


def test_names_that_no_picture_can_have_come_back_too(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    names = ("a.b", "a,b", "")
    values = np.ones((*GRID.shape, 3))
    brdfit.write_table(Table(values, grid=GRID, channels=names), path)
    assert brdfit.read_table(path).channels == names


def test_samples_are_its_cells(tmp_path: Path) -> None:
    path, table = tmp_path / "a.exr", table_of()
    brdfit.write_table(table, path)
    with pytest.warns(brdfit.errors.BrdfitWarning):
        samples = brdfit.read_samples(path, count=5, seed=2)
    assert samples.rows is not None
    expected = table.values.reshape(-1, 3)[samples.rows - 1]
    np.testing.assert_allclose(samples.value, expected, rtol=1e-7)


def test_what_float32_cannot_hold_is_refused(tmp_path: Path) -> None:
    huge = Table(np.full((*GRID.shape, 1), 1e39), grid=GRID)
    with pytest.raises(UsageError, match="too large for float32"):
        brdfit.write_table(huge, tmp_path / "a.exr")
    assert not list(tmp_path.iterdir())


def test_other_pictures_are_told_from_tables(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "sky.exr"
    write_exr({name: np.ones((4, 8)) for name in "RGB"}, {}, path)
    with pytest.raises(FormatError, match=r"no table that brdfit wrote.*--environment"):
        brdfit.read_table(path)
    assert capfd.readouterr().out == ""


def altered(path: Path, **changes: object) -> Path:
    """Write the picture of a table again with another attribute."""
    brdfit.write_table(tiny_table(), path)
    planes, header = read_exr(path)
    attribute = {**json.loads(header["brdfit"]), **changes}
    write_exr(planes, {"brdfit": json.dumps(attribute)}, path)
    return path


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"grid": [6, 5]}, "attribute 'brdfit' of the header is damaged"),
        ({"grid": [6, 5, 1 << 40]}, "sizes that no atlas has"),
        ({"grid": [1, 5, 8]}, "at least 2 nodes"),
        ({"grid": [6, 5, 16]}, r"3 channels of 40x12 pixels, but the file has 20x12"),
        ({"planes": ["R", "G", "R"]}, "sizes that no atlas has"),
        ({"planes": ["R", "G", "Z"]}, "no channel 'Z'"),
        ({"source": 3}, "attribute 'brdfit'"),
        ({"version": 2}, "version 2 .* Update brdfit"),
    ],
)
def test_a_header_that_does_not_fit_is_named(
    changes: dict[str, object], match: str, tmp_path: Path
) -> None:
    with pytest.raises(CorruptFile, match=match):
        brdfit.read_table(altered(tmp_path / "a.exr", **changes))


def test_damaged_pixels_are_an_error_and_nothing_is_printed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.exr"
    brdfit.write_table(tiny_table(), path)
    content = bytearray(path.read_bytes())
    content[-200:-100] = bytes(100)
    path.write_bytes(content)
    with pytest.raises(CorruptFile, match="OpenEXR cannot read it"):
        brdfit.read_table(path)
    # what the library says of it goes to the standard error only: the output may be JSON
    assert capfd.readouterr().out == ""


def test_names_of_channels_that_are_no_text_do_not_end_the_process(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    brdfit.write_table(tiny_table(), path)
    content = path.read_bytes()
    assert content.count(b"\0B\0\x02") == 1
    path.write_bytes(content.replace(b"\0B\0\x02", b"\0\xc2\0\x02"))
    with pytest.raises(CorruptFile, match=r"OpenEXR cannot read it .*utf-8"):
        brdfit.read_table(path)


def test_headers_that_do_not_end_are_named(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    brdfit.write_table(tiny_table(), path)
    content = path.read_bytes()
    for cut, match in ((4, "does not end"), (12, "does not end"), (60, "beyond the end")):
        path.write_bytes(content[:cut])
        with pytest.raises(CorruptFile, match=match):
            brdfit.read_table(path)


def test_more_pixels_than_the_bytes_can_hold_are_refused_before_memory_is_set_aside(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a.exr"
    write_exr({"Y": np.ones((8, 16))}, {}, path)
    content = path.read_bytes()
    window = b"dataWindow\0box2i\0\x10\0\0\0" + bytes(8)
    at = content.index(window) + len(window)
    path.write_bytes(content[:at] + b"\xff\x1f\0\0\xff\x1f\0\0" + content[at + 8 :])
    with pytest.raises(CorruptFile, match=r"8192 x 8192 pixels, which [0-9]+ bytes cannot hold"):
        brdfit.read_table(path)


def test_an_even_picture_is_no_reason_to_doubt(tmp_path: Path) -> None:
    write_exr({"Y": np.ones((512, 1024))}, {}, tmp_path / "a.exr")
    assert read_exr(tmp_path / "a.exr")[0]["Y"].shape == (512, 1024)
