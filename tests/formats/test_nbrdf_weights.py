"""NBRDF weights as a format: one network, one of an archive, and what is none."""

from __future__ import annotations

import io
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, MissingExtra, UsageError
from brdfit.grid import MERL_GRID
from brdfit.populations import population

from small_files import network_file

h5py = pytest.importorskip("h5py", reason="the extra 'networks' is not installed")

# made-up networks reflect in any direction
pytestmark = pytest.mark.filterwarnings("ignore::brdfit.errors.ConventionWarning")


def archive_of(path: Path, members: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(f"any/{name}", content)
    return path


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    members = {"walnut.h5": network_file(1), "brick.h5": network_file(2), "walnut.json": b"{}"}
    return archive_of(tmp_path / "two.zip", members)


@pytest.mark.filterwarnings("ignore:.*published archive:brdfit.errors.DataQualityWarning")
def test_a_table_is_the_network_at_the_nodes(archive: Path) -> None:
    table = brdfit.read_table(archive, material="walnut")
    assert table.grid == MERL_GRID
    assert table.missing == 0
    assert table.channels == ("R", "G", "B")
    cells = MERL_GRID.cells[::4001]
    wi, wo = MERL_GRID.directions(cells)
    # the population of the same archive is another way to the same numbers
    members = population(archive)
    expected = members.evaluate(wi, wo)[:, members.members.index("walnut")]
    np.testing.assert_allclose(table.values.reshape(-1, 3)[cells], expected, rtol=1e-5, atol=1e-7)


def test_a_file_of_its_own_is_the_member_of_an_archive(archive: Path, tmp_path: Path) -> None:
    path = tmp_path / "walnut.h5"
    path.write_bytes(network_file(1))
    alone, member = brdfit.read_table(path), brdfit.read_table(archive, material="walnut")
    np.testing.assert_array_equal(alone.values, member.values)
    assert alone.source.metadata["material"] == member.source.metadata["material"] == "walnut"


def test_samples_are_drawn_from_the_cells(archive: Path) -> None:
    table = brdfit.read_table(archive, material="brick")
    samples = brdfit.read_samples(archive, material="brick", count=200, seed=4)
    assert len(samples) == 200
    assert samples.rows is not None
    expected = table.values.reshape(-1, 3)[samples.rows - 1]
    np.testing.assert_allclose(samples.value, expected, rtol=1e-5, atol=1e-7)
    assert "200 of 1,111,430 cells of the MERL grid, drawn with seed 4" in samples.source.notes


def test_the_material_of_an_archive_must_be_one_of_it(archive: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"holds 2 materials.*brick, walnut"):
        brdfit.read_table(archive)
    with pytest.raises(UsageError, match=r"no material 'brik'\. Did you mean 'brick'\?"):
        brdfit.read_table(archive, material="brik")
    only = archive_of(tmp_path / "one.zip", {"oak.h5": network_file(3)})
    assert brdfit.read_table(only).source.metadata["material"] == "oak"
    alone = tmp_path / "oak.h5"
    alone.write_bytes(network_file(3))
    with pytest.raises(UsageError, match="holds one network"):
        brdfit.read_table(alone, material="oak")


def endless() -> bytes:
    made = io.BytesIO()
    with h5py.File(made, "w") as file:
        group = file.create_group("dense_1/dense_1")
        group.create_dataset("kernel:0", shape=(1 << 40, 1 << 20), dtype="f4", chunks=(64, 64))
    return made.getvalue()


def not_finite() -> bytes:
    made = io.BytesIO(network_file())
    with h5py.File(made, "r+") as file:
        file["dense_2/dense_2/bias:0"][3] = np.nan
    return made.getvalue()


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (network_file(shapes=((8, 21), (21, 21), (21, 3))), r"dense_1 has shape \(8, 21\)"),
        (network_file()[:2000], "not a Keras file"),
        (endless(), r"dense_1 has shape \(1099511627776, 1048576\)"),
        (not_finite(), "dense_2 holds a number that is not finite"),
    ],
    ids=["wide", "cut", "endless", "nan"],
)
def test_what_is_no_network_of_the_shape_is_named(
    content: bytes, match: str, tmp_path: Path
) -> None:
    path = tmp_path / "odd.h5"
    path.write_bytes(content)
    with pytest.raises(CorruptFile, match=match):
        brdfit.read_table(path)


def test_without_h5py_the_extra_is_named(archive: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingExtra, match=r"brdfit\[networks\]"):
        brdfit.read_table(archive, material="brick")


def test_the_published_archive_is_read_by_name(shared_data: Path) -> None:
    path = shared_data / "nbrdf" / "merl_nbrdf.zip"
    table = brdfit.read_table(path, material="alum-bronze")
    assert table.source.format == "nbrdf"
    wi = np.array([[0.0, 0.0, 1.0]])
    # bronze: red above green above blue
    assert (np.diff(table.evaluate(wi, wi)) < 0.0).all()
