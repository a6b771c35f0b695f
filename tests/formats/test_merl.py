"""MERL `.binary`: layout, scales, mask, and what a table must be like to be written."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brdfit.errors import CorruptFile, DataQualityWarning, UsageError
from brdfit.formats.merl import SHEET
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import MERL_GRID, Grid
from brdfit.samples import Samples
from brdfit.table import Table

BYTES = 34_992_012


def read_independently(path: Path) -> np.ndarray:
    """Return f_r (3, 90, 90, 180) by the format's description alone."""
    with open(path, "rb") as stream:
        n_h, n_d, n_phi = struct.unpack("<iii", stream.read(12))
        assert (n_h, n_d, n_phi) == (90, 90, 180)
        planes = np.fromfile(stream, dtype="<f8").reshape(3, 90, 90, 180)
    return planes * np.array([1.0, 1.15, 1.66])[:, None, None, None] / 1500.0


def write(table: Table, path: Path) -> Path:
    assert SHEET.write_table is not None
    SHEET.write_table(table, path)
    return path


def read(path: Path) -> Table:
    assert SHEET.read_table is not None
    return SHEET.read_table(path)


def read_samples(path: Path, **options: int) -> Samples:
    assert SHEET.read_samples is not None
    return SHEET.read_samples(path, **options)


@pytest.fixture(scope="module")
def table() -> Table:
    """Return a table over nine orders of magnitude with a hole of 1 % of its cells."""
    rng = np.random.default_rng(5)
    values = np.exp(rng.uniform(-12.0, 9.0, (*MERL_GRID.shape, 3)))
    valid = rng.uniform(size=MERL_GRID.shape) > 0.01
    return Table(values, valid=valid)


@pytest.fixture(scope="module")
def written(table: Table, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(table, tmp_path_factory.mktemp("merl") / "made.binary")


def test_a_written_table_reads_the_same_by_an_independent_reader(
    table: Table, written: Path
) -> None:
    found = read_independently(written).transpose(1, 2, 3, 0)
    assert written.stat().st_size == BYTES
    np.testing.assert_allclose(found[table.mask], table.values[table.mask], rtol=4e-16)
    assert (found[~table.mask] < 0.0).all()


def test_reading_back_gives_the_table_and_its_holes(table: Table, written: Path) -> None:
    back = read(written)
    assert np.array_equal(back.mask, table.mask)
    np.testing.assert_allclose(back.values[back.mask], table.values[table.mask], rtol=4e-16)
    assert f"{table.missing:,} of 1,111,430 cells" in back.source.notes[0]
    assert len(back.source.sha256) == 64
    assert back.source.name == "made.binary"


def test_writing_what_was_read_gives_the_same_bytes(written: Path, tmp_path: Path) -> None:
    again = write(read(written), tmp_path / "again.binary")
    assert again.read_bytes() == written.read_bytes()


def test_scales_planes_and_index_are_those_of_the_description(tmp_path: Path) -> None:
    planes = np.full((3, MERL_GRID.size), 0.25)
    flat = 17 + 180 * (5 + 90 * 3)
    planes[:, flat] = (1500.0, 3000.0, 4500.0)
    planes[1, flat + 1] = -0.5
    path = tmp_path / "by_hand.binary"
    path.write_bytes(struct.pack("<3i", 90, 90, 180) + planes.astype("<f8").tobytes())
    table = read(path)
    np.testing.assert_allclose(table.values[3, 5, 17], [1.0, 2.3, 4.98], rtol=1e-15)
    assert not table.mask[3, 5, 18]
    assert table.values[3, 5, 18, 1] < 0.0
    assert table.missing == 1


def test_a_cell_with_one_channel_missing_or_not_finite_is_masked_not_clamped(
    written: Path, tmp_path: Path
) -> None:
    content = bytearray(written.read_bytes())
    cells = np.flatnonzero(read(written).mask)[:4]
    for cell, number in zip(cells, (-1e-9, np.nan, np.inf, 0.0), strict=True):
        content[12 + 8 * cell : 20 + 8 * cell] = struct.pack("<d", number)
    path = tmp_path / "holes.binary"
    path.write_bytes(content)
    mask = read(path).mask.reshape(-1)[cells]
    assert mask.tolist() == [False, False, False, True]


def test_a_grey_table_is_written_into_all_three_channels(tmp_path: Path) -> None:
    grey = Table(np.full((*MERL_GRID.shape, 1), 0.3, dtype=np.float32))
    found = read_independently(write(grey, tmp_path / "grey.binary"))
    np.testing.assert_allclose(found[:, grey.mask], np.float32(0.3), rtol=1e-15)
    assert "one channel is written three times" in SHEET.loses


def test_values_below_zero_become_zero_with_a_warning_that_counts_them(tmp_path: Path) -> None:
    values = np.full((*MERL_GRID.shape, 3), 0.5)
    values[10, 10, 10, 2] = -1e-3
    values[11, 10, 10, :] = -1e-3
    table = Table(values)
    with pytest.warns(DataQualityWarning, match="4 values below zero were written as 0"):
        write(table, tmp_path / "x.binary")
    back = read(tmp_path / "x.binary")
    assert back.missing == 0
    assert back.values[10, 10, 10, 2] == 0.0
    assert back.values[10, 10, 10, 0] == 0.5
    assert values[10, 10, 10, 2] == -1e-3


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (Table(np.ones((5, 4, 6, 3)), grid=Grid(5, 4, 6)), r"has 5 x 4 x 6 cells .* 90 x 90 x 180"),
        (Table(np.ones((*MERL_GRID.shape, 2))), r"2 channels \(channel0, channel1\)"),
        (
            Table(np.ones((*MERL_GRID.shape, 3)), wavelengths=np.array([450.0, 550.0, 650.0])),
            "Convert it to linear sRGB first .brdfit.render",
        ),
        (Table(np.ones((*MERL_GRID.shape, 3)), channels=("B", "G", "R")), "channels .B, G, R."),
        (Table(np.full((*MERL_GRID.shape, 3), 1e307)), "too large for a MERL file"),
    ],
)
def test_tables_that_the_format_cannot_hold_are_refused_and_nothing_is_left(
    table: Table, message: str, tmp_path: Path
) -> None:
    with np.errstate(over="ignore"), pytest.raises(UsageError, match=message):
        write(table, tmp_path / "x.binary")
    assert list(tmp_path.iterdir()) == []


HEADER = struct.pack("<3i", 90, 90, 180)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lambda: HEADER[:7], "has 7 bytes but a MERL table has 34,992,012"),
        (lambda: HEADER, "has 12 bytes .* has 34,992,012. It looks truncated"),
        (lambda: HEADER + bytes(1000), "has 1,012 bytes"),
        (lambda: HEADER + bytes(17_496_000), "17,496,012 bytes .* float32, or cut in the middle"),
        (lambda: HEADER + bytes(11_664_000), "one channel only"),
        (lambda: HEADER + bytes(BYTES - 11), "34,992,013 bytes .* appended"),
        (lambda: struct.pack(">3i", 90, 90, 180) + bytes(9), "big-endian"),
        (
            lambda: struct.pack("<3i", 90, 180, 90) + bytes(BYTES - 12),
            "theta_d is 180 instead of 90, phi_d is 90 instead of 180",
        ),
        (lambda: struct.pack("<3i", -1, 90, 180) + bytes(9), "theta_h is -1 instead of 90"),
    ],
)
def test_damage_is_named_with_both_sizes(
    content: Callable[[], bytes], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "damaged.binary"
    path.write_bytes(content())
    with pytest.raises(CorruptFile, match=message):
        read(path)


def test_all_valid_cells_are_samples_at_the_directions_of_their_nodes(
    table: Table, written: Path
) -> None:
    drawn = read_samples(written, count=500, seed=3)
    assert len(drawn) == 500
    assert drawn.rows is not None
    assert len(set(drawn.rows)) == 500
    assert table.mask.reshape(-1)[drawn.rows - 1].all()
    nearest = MERL_GRID.nearest(*half_diff_from_directions(drawn.wi, drawn.wo))
    node_h, node_d, _ = MERL_GRID.half_diff(drawn.rows - 1)
    off_poles = (node_h > 0.0) & (node_d > 0.0)
    assert np.array_equal(nearest[off_poles], (drawn.rows - 1)[off_poles])
    expected = table.values.reshape(-1, 3)[drawn.rows - 1]
    np.testing.assert_allclose(drawn.value, expected, rtol=4e-16)
    assert np.array_equal(drawn.rows, read_samples(written, count=500, seed=3).rows)
    assert not np.array_equal(drawn.rows, read_samples(written, count=500, seed=4).rows)
    assert "drawn with seed 3" in drawn.source.notes[-1]


def test_more_samples_than_cells_cannot_be_drawn(written: Path) -> None:
    with pytest.raises(UsageError, match=r"count is 2000000; give a number from 1 to"):
        read_samples(written, count=2_000_000)
    assert SHEET.read_table is not None
    with pytest.raises(UsageError, match="a table is always read whole"):
        SHEET.read_table(written, count=5)


def test_the_header_is_recognised_under_any_name_and_the_suffix_with_a_wrong_header() -> None:
    assert SHEET.sniff(Path("a.dat"), HEADER)
    assert SHEET.sniff(Path("a.binary"), struct.pack("<3i", 90, 90, 90))
    assert not SHEET.sniff(Path("a.dat"), struct.pack("<3i", 90, 90, 90))
    assert not SHEET.sniff(Path("a.binary"), b"some text, not numbers")
