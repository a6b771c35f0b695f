"""brdfit's `.npz`: nothing is lost, and no archive does harm."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.formats.npz import SHEET, archive
from brdfit.grid import Grid
from brdfit.samples import Flag, Samples, Source
from brdfit.table import Table

SOURCE = Source(
    name="blåu \udc80.astm",
    format="astm",
    sha256="ab" * 32,
    convention="radians",
    notes=("one", "two"),
    metadata={"OPERATOR": 'a "quoted" name\n'},
)


def some_samples() -> Samples:
    rng = np.random.default_rng(11)
    wi, wo = rng.normal(size=(2, 7, 3))
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    value = rng.uniform(size=(7, 2)) * np.pi
    value[2] = np.nan
    value[3, 0] = -1e-300
    return Samples(
        wi=wi,
        wo=wo,
        value=value,
        sigma=np.full((7, 2), 0.1),
        wavelengths=np.array([450.5, 650.25]),
        channels=("blue", "red"),
        flags=np.array([0, 0, 64, 0, 128, 0, 0]),
        rows=np.arange(10, 17),
        source=SOURCE,
    )


def some_table(dtype: str = "f8") -> Table:
    rng = np.random.default_rng(12)
    grid = Grid(5, 4, 6)
    values = rng.uniform(-0.1, 1.0, (5, 4, 6, 2)).astype(dtype)
    values[1, 1, 1] = np.nan
    valid = rng.uniform(size=grid.shape) > 0.3
    return Table(values, grid=grid, valid=valid, channels=("a", "b"), source=SOURCE)


def read_samples(path: Path) -> Samples:
    assert SHEET.read_samples is not None
    return SHEET.read_samples(path)


def read_table(path: Path) -> Table:
    assert SHEET.read_table is not None
    return SHEET.read_table(path)


@pytest.fixture
def samples_file(tmp_path: Path) -> Path:
    assert SHEET.write_samples is not None
    path = tmp_path / "samples.npz"
    SHEET.write_samples(some_samples(), path)
    return path


@pytest.fixture
def table_file(tmp_path: Path) -> Path:
    assert SHEET.write_table is not None
    path = tmp_path / "table.npz"
    SHEET.write_table(some_table(), path)
    return path


def same(a: Any, b: Any) -> bool:
    return bool(np.array_equal(a, b, equal_nan=True)) and a.dtype == b.dtype


def test_samples_come_back_bit_by_bit(samples_file: Path) -> None:
    before, after = some_samples(), read_samples(samples_file)
    for name in ("wi", "wo", "value", "sigma", "wavelengths", "flags", "rows"):
        assert same(getattr(before, name), getattr(after, name)), name
    assert after.channels == ("blue", "red")
    assert after.source == SOURCE
    assert after.source.metadata == SOURCE.metadata
    assert (after.bits[4] & Flag.REJECTED) != 0


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_a_table_on_a_small_asymmetric_grid_comes_back_bit_by_bit(
    tmp_path: Path, dtype: str
) -> None:
    assert SHEET.write_table is not None
    before = some_table(dtype)
    SHEET.write_table(before, tmp_path / "t.npz")
    after = read_table(tmp_path / "t.npz")
    assert after.grid == Grid(5, 4, 6)
    assert same(before.values, after.values)
    assert same(before.mask, after.mask)
    assert after.wavelengths is None
    assert (after.channels, after.source) == (("a", "b"), SOURCE)


def test_optional_arrays_may_be_absent_and_no_samples_are_samples(tmp_path: Path) -> None:
    assert SHEET.write_samples is not None
    none = np.empty((0, 3))
    SHEET.write_samples(Samples(wi=none, wo=none, value=none), tmp_path / "s.npz")
    after = read_samples(tmp_path / "s.npz")
    assert (len(after), after.n_channels, after.sigma, after.rows) == (0, 3, None, None)


def test_the_same_content_gives_the_same_bytes_and_numpy_reads_them(
    samples_file: Path, tmp_path: Path
) -> None:
    assert SHEET.write_samples is not None
    SHEET.write_samples(read_samples(samples_file), tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == samples_file.read_bytes()
    with np.load(samples_file, allow_pickle=False) as arrays:
        assert same(arrays["value"], some_samples().value)
        assert json.loads(arrays["brdfit"].tobytes())["kind"] == "samples"


def test_samples_are_not_a_table_and_the_message_says_what_to_call(
    samples_file: Path, table_file: Path
) -> None:
    with pytest.raises(UsageError, match=r"holds samples, not table.*read_samples"):
        read_table(samples_file)
    with pytest.raises(UsageError, match=r"holds table, not samples.*read_table"):
        read_samples(table_file)


def test_a_file_cut_anywhere_is_reported_as_damaged(samples_file: Path, tmp_path: Path) -> None:
    content = samples_file.read_bytes()
    cut = tmp_path / "cut.npz"
    for end in range(2, len(content), 7):
        cut.write_bytes(content[:end])
        with pytest.raises(CorruptFile):
            read_samples(cut)


def test_an_altered_byte_is_noticed_or_harmless(samples_file: Path, tmp_path: Path) -> None:
    content = samples_file.read_bytes()
    altered_file = tmp_path / "altered.npz"
    rng = np.random.default_rng(4)
    refused = 0
    for position in rng.choice(len(content), 400, replace=False):
        altered = bytearray(content)
        altered[position] ^= int(rng.integers(1, 256))
        altered_file.write_bytes(altered)
        try:
            after = read_samples(altered_file)
        except FormatError:
            refused += 1
        else:
            assert same(after.value, some_samples().value)
            assert same(after.wi, some_samples().wi)
    assert refused > 200


def altered_archive(
    path: Path, change: dict[str, Any], drop: str = "", compress: int = zipfile.ZIP_STORED
) -> Path:
    """Rewrite an archive with arrays (or raw bytes) exchanged, added or dropped."""
    with np.load(path) as arrays:
        members: dict[str, Any] = {name: arrays[name] for name in arrays if name != drop}
    with zipfile.ZipFile(path, "w", compress) as target:
        for name, content in {**members, **change}.items():
            if not isinstance(content, bytes):
                buffer = io.BytesIO()
                np.lib.format.write_array(buffer, np.asarray(content), allow_pickle=True)
                content = buffer.getvalue()
            target.writestr(f"{name}.npy", content)
    return path


def header(**changes: Any) -> np.ndarray:
    source = {"name": "", "format": "", "sha256": "", "convention": "", "notes": [], "metadata": {}}
    content = {"version": 1, "kind": "samples", "channels": ["a", "b"], "source": source}
    return np.frombuffer(json.dumps({**content, **changes}).encode(), dtype=np.uint8)


def huge_array_header() -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        buffer, {"descr": "<f8", "fortran_order": False, "shape": (2**40, 3)}
    )
    return buffer.getvalue() + bytes(64)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"brdfit": header(version=99)}, "version 99 of the layout but this brdfit reads 1"),
        ({"brdfit": header(kind="picture")}, "holds 'picture' but one of samples, table"),
        ({"brdfit": header(channels="ab")}, "'channels' is 'ab' but names"),
        ({"brdfit": header(channels=["a"])}, "do not fit together: .*channel"),
        ({"brdfit": header(source={"name": 3})}, "'source' in the header is"),
        ({"brdfit": np.frombuffer(b"[" * 5000, np.uint8)}, "header is not JSON"),
        ({"brdfit": np.frombuffer(b"[1]", np.uint8)}, "an object was expected"),
        ({"extra": np.ones(3)}, "'extra' does not belong to samples"),
        ({"value": np.ones((6, 2))}, "do not fit together"),
        ({"value": np.ones(7)}, r"'value' has the shape \(7,\) .* 2 dimensions of kind 'f'"),
        ({"value": np.ones((7, 2), dtype=int)}, "'value' has .* of kind 'f'"),
        ({"value": np.array([{}] * 7, dtype=object)}, "only plain numbers"),
        ({"value": huge_array_header()}, r"declares the shape \(1099511627776, 3\)"),
        ({"value": b"no array at all"}, "'value' is damaged"),
    ],
)
def test_damage_is_named(samples_file: Path, change: dict[str, Any], message: str) -> None:
    altered_archive(samples_file, change)
    with pytest.raises(CorruptFile, match=message):
        read_samples(samples_file)


@pytest.mark.parametrize(
    ("name", "message"),
    [("value", "'value' of the samples is missing"), ("brdfit", "not one of brdfit's")],
)
def test_a_missing_array_is_named(samples_file: Path, name: str, message: str) -> None:
    altered_archive(samples_file, {}, drop=name)
    with pytest.raises(CorruptFile, match=message):
        read_samples(samples_file)


def test_a_mask_of_another_shape_is_refused(table_file: Path) -> None:
    altered_archive(table_file, {"valid": np.ones((5, 4, 7), dtype=bool)})
    with pytest.raises(CorruptFile, match=r"valid has the shape \(5, 4, 7\)"):
        read_table(table_file)


def test_a_grid_of_a_single_node_is_refused(table_file: Path) -> None:
    altered_archive(
        table_file, {"values": np.ones((1, 4, 6, 2)), "valid": np.ones((1, 4, 6), bool)}
    )
    with pytest.raises(CorruptFile, match="at least 2 nodes"):
        read_table(table_file)


def test_compressed_archives_are_read_up_to_a_limit(
    samples_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    altered_archive(samples_file, {}, compress=zipfile.ZIP_DEFLATED)
    assert same(read_samples(samples_file).value, some_samples().value)
    monkeypatch.setattr(archive, "MOST_BYTES", 1000)
    with pytest.raises(CorruptFile, match=r"declares to unpack to .* more than the 1,000"):
        read_samples(samples_file)


@pytest.mark.parametrize("content", [b"PK", b"PK\x03\x04" + bytes(50), b"PK\x05\x06" + bytes(18)])
def test_what_only_begins_like_an_archive_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.npz"
    path.write_bytes(content)
    assert SHEET.sniff(path, content)
    with pytest.raises(CorruptFile):
        read_samples(path)


def test_writing_does_not_alter_what_is_written(tmp_path: Path) -> None:
    assert SHEET.write_samples is not None
    samples = some_samples()
    before = samples.value.tobytes(), samples.bits.tobytes()
    SHEET.write_samples(samples, tmp_path / "s.npz")
    assert (samples.value.tobytes(), samples.bits.tobytes()) == before
    assert [path.name for path in tmp_path.iterdir()] == ["s.npz"]
