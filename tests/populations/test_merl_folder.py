"""A folder of MERL files: made here from the format's description, with holes."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import DataQualityWarning, PopulationError
from brdfit.files import sha256_of_file
from brdfit.formats import read_table
from brdfit.grid import MERL_GRID, Grid
from brdfit.models import Ggx
from brdfit.populations import Population, check, columns, merl_folder, population
from brdfit.populations.merl_folder import MerlFile, published_sha256, read_merl_folder

Draw = Callable[[int], tuple[FloatArray, FloatArray]]
SCALES = np.array([1.0, 1.15, 1.66]) / 1500.0
HOLE = slice(300_000, 300_400)


def write_merl(path: Path, model: Ggx) -> None:
    planes = np.full((3, MERL_GRID.size), -1.0)
    values = model.evaluate(*MERL_GRID.directions(MERL_GRID.cells))
    planes[:, MERL_GRID.cells] = values.T / SCALES[:, None]
    planes[:, HOLE] = -1.0
    path.write_bytes(struct.pack("<3i", 90, 90, 180) + planes.astype("<f8").tobytes())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two files, one of them named as a MERL material."""
    path = tmp_path_factory.mktemp("merl")
    write_merl(path / "alum-bronze.binary", Ggx([0.3, 0.2, 0.1], 0.05, 0.3))
    write_merl(path / "my-paint.binary", Ggx([0.05, 0.1, 0.4], 0.04, 0.5))
    (path / "readme.txt").write_text("not a table")
    return path


@pytest.fixture(scope="module", autouse=True)
def cache_of_the_module(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A cache that lasts for the module, unless a test asks for one of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BRDFIT_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def paints(folder: Path) -> Population:
    """The population of the folder, read once for the whole module."""
    with pytest.warns(DataQualityWarning, match=r"alum-bronze.*and 1 more"):
        return population(folder)


def test_members_are_the_files(paints: Population) -> None:
    assert paints.members == ("alum-bronze", "my-paint")
    assert paints.materials == paints.members


def test_values_are_those_of_the_tables(
    paints: Population, folder: Path, random_directions: Draw
) -> None:
    wi, wo = random_directions(2000)
    found = paints.evaluate(wi, wo)
    assert found.shape == (2000, 2, 3)
    for member, name in enumerate(paints.members):
        expected = read_table(folder / f"{name}.binary").evaluate(wi, wo)
        # beside a hole a table leaves out the corners it lacks, a population has them filled
        ratio = np.abs(found[:, member] / expected - 1.0)
        assert np.quantile(ratio, 0.98) < 1e-5
        assert ratio.max() < 0.2


def test_at_a_node_the_value_is_that_of_the_file(paints: Population) -> None:
    cells = MERL_GRID.cells[1000:200_000:999]
    wi, wo = MERL_GRID.directions(cells)
    expected = Ggx([0.3, 0.2, 0.1], 0.05, 0.3).evaluate(wi, wo)
    found = paints.subset(["alum-bronze"]).evaluate(wi, wo)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_values_at_the_horizon_are_finite_and_nothing_lies_below(paints: Population) -> None:
    theta = np.pi / 2 - np.array([1e-9, 1e-4, 0.01, -0.01])
    wi = np.stack([np.sin(theta), np.zeros(4), np.cos(theta)], axis=-1)
    wo = wi * [-1.0, 1.0, 1.0]
    found = paints.evaluate(wi, wo)
    assert np.isfinite(found).all()
    assert (found[:3] > 0.0).all()
    assert not found[3].any()


def test_a_hole_is_filled_from_the_nearest_cell(paints: Population) -> None:
    inside = np.intersect1d(np.arange(HOLE.start, HOLE.stop), MERL_GRID.cells)
    assert inside.size
    found = paints.evaluate(*MERL_GRID.directions(inside))
    expected = Ggx([0.3, 0.2, 0.1], 0.05, 0.3).evaluate(*MERL_GRID.directions(inside))
    np.testing.assert_allclose(np.log(found[:, 0]), np.log(expected), atol=0.3)


def test_the_check_tells_altered_from_unknown(folder: Path, cache: Path) -> None:
    report = check(folder)
    verdicts = {finding.subject: finding.verdict for finding in report.findings}
    assert verdicts["alum-bronze.binary"] == "altered"
    assert verdicts["my-paint.binary"] == "unknown"
    assert "99 of the 100 materials" in str(report.findings)
    assert not report.ok


def test_a_published_file_is_known_and_a_renamed_one_too() -> None:
    sha256 = published_sha256()["chrome"]
    assert len(published_sha256()) == 100
    assert MerlFile(Path("chrome.binary"), sha256).verdict == "published"
    renamed = MerlFile(Path("brass.binary"), sha256)
    assert renamed.verdict == "renamed"
    assert "'chrome'" in renamed.explanation


def test_hashes_are_computed_once(
    folder: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = read_merl_folder(folder)
    assert first.tables[0].sha256 == sha256_of_file(first.tables[0].path)

    def fail(_: Path) -> str:
        raise AssertionError("read again")

    monkeypatch.setattr(merl_folder, "sha256_of_file", fail)
    assert read_merl_folder(folder).fingerprint == first.fingerprint


def test_a_folder_without_tables_says_what_was_expected(tmp_path: Path, cache: Path) -> None:
    with pytest.raises(PopulationError, match=r"found no \.binary file"):
        population(tmp_path)


def test_a_truncated_file_is_named_with_the_way_out(tmp_path: Path, cache: Path) -> None:
    (tmp_path / "short.binary").write_bytes(struct.pack("<3i", 90, 90, 180) + bytes(1000))
    with (
        pytest.warns(DataQualityWarning),
        pytest.raises(PopulationError, match=r"short\.binary cannot be used.*take it out"),
    ):
        population(tmp_path)


def test_columns_on_another_grid_are_interpolated(paints: Population) -> None:
    found = columns(paints, Grid(6, 6, 8))
    wi, wo = found.grid.directions(found.cells)
    np.testing.assert_allclose(found.load(0), paints.log_values(wi, wo)[:, :, 0], atol=0.02)
