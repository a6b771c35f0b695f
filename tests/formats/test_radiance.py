"""Klems matrices and tensor trees: our reader, and Radiance's own where it is installed."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, DataQualityWarning, FormatError, UsageError
from brdfit.formats.klems.patches import BASES, FULL
from brdfit.formats.tensortree.square import directions_of
from brdfit.formats.xyz import xyz_from_linear_rgb
from brdfit.geometry import directions_from_spherical, half_diff_from_directions
from brdfit.grid import Grid
from brdfit.table import Table

from small_files import tiny_table

TREE = """<?xml version="1.0"?>
<WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer>
<DataDefinition><IncidentDataStructure>TensorTree3</IncidentDataStructure></DataDefinition>
<WavelengthData><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock>
<WavelengthDataDirection>Reflection Back</WavelengthDataDirection>
<AngleBasis>LBNL/Shirley-Chiu</AngleBasis><ScatteringDataType>BRDF</ScatteringDataType>
<ScatteringData>DATA</ScatteringData></WavelengthDataBlock></WavelengthData>
</Layer></Optical></WindowElement>
"""
pytestmark = pytest.mark.filterwarnings("ignore:.*usable|.*used:brdfit.errors.DataQualityWarning")


def read(folder: Path, text: str) -> brdfit.Samples:
    path = folder / "a.xml"
    path.write_text(text)
    return brdfit.read_samples(path)


def test_equal_areas_of_the_square_are_equal_areas_of_the_disk() -> None:
    n = 200
    middles = (np.arange(n) + 0.5) / n
    w = directions_of(*np.meshgrid(middles, middles))
    radius = np.hypot(w[..., 0], w[..., 1])
    np.testing.assert_allclose(np.sum(w**2, axis=-1), 1.0)
    for r in (0.3, 0.6, 0.9):
        assert abs(np.mean(radius < r) - r * r) < 0.01
    angle = np.arctan2(w[..., 1], w[..., 0])
    assert abs(np.mean((angle > 0.2) & (angle < 1.2)) - 1.0 / (2.0 * np.pi)) < 0.005


def test_a_tree_is_read_with_its_leaves_in_their_places(tmp_path: Path) -> None:
    leaves = " ".join(f"{{ {k} }}" for k in range(1, 9))
    samples = read(tmp_path, TREE.replace("DATA", f"{{ {leaves} }}"))
    # bit 0 is the light: the other half is never reached
    assert samples.value[:, 0].tolist() == [1.0, 3.0, 5.0, 7.0]
    np.testing.assert_allclose(samples.wi[:, 0], -0.5)
    signs = np.sign(samples.wo[:, :2]).tolist()
    assert signs == [[-1, -1], [1, -1], [-1, 1], [1, 1]]
    grid = read(tmp_path, TREE.replace("DATA", "{ 1 5 3 7 2 6 4 8 }"))
    np.testing.assert_array_equal(np.sort(grid.value, axis=0), np.sort(samples.value, axis=0))
    deep = leaves.replace("{ 3 }", "{ " + "{ 9 } " * 8 + "}")
    assert len(read(tmp_path, TREE.replace("DATA", f"{{ {deep} }}"))) == 3 + 8


@pytest.mark.parametrize(
    ("data", "match"),
    [
        ("{ 1 2 3 }", "has 3 values"),
        ("{ { 1 } { 2 } }", "2 nodes"),
        ("{ 1", "not closed"),
        ("{ 1 } }", "follows it"),
        ("{ 1 } 2", "follows it"),
        ("1", "outside a node"),
        ("{ }", "0 nodes and 0 values"),
        ("{ x }", "no number"),
        ("{" * 99, "too deep"),
        ("", "not closed"),
    ],
)
def test_a_damaged_tree_says_what_is_wrong(tmp_path: Path, data: str, match: str) -> None:
    with pytest.raises(CorruptFile, match=match):
        read(tmp_path, TREE.replace("DATA", data))


def test_other_xml_is_refused_with_a_reason(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="sides found: transmission front"):
        read(tmp_path, TREE.replace("Reflection Back", "Transmission Front"))
    with pytest.raises(FormatError, match="document type"):
        read(tmp_path, TREE.replace("<WindowElement ", "<!DOCTYPE x><WindowElement "))
    with pytest.raises(CorruptFile, match="not well-formed"):
        read(tmp_path, TREE[:-30])
    brdfit.write_table(tiny_table(channels=1), tmp_path / "k.xml", format="klems")
    text = (tmp_path / "k.xml").read_text()
    with pytest.raises(FormatError, match="ColumnAngleBasis is 'LBNL/Klems Fu'"):
        read(
            tmp_path,
            text.replace("<ColumnAngleBasis>LBNL/Klems Full", "<ColumnAngleBasis>LBNL/Klems Fu"),
        )
    with pytest.raises(CorruptFile, match="21025 were expected"):
        read(tmp_path, text.replace("<ScatteringData>\n", "<ScatteringData>\n0.5 "))


def test_the_patches_of_klems() -> None:
    assert [basis.size for basis in BASES.values()] == [145, 73, 41]
    middles = FULL.middles()
    np.testing.assert_allclose(np.linalg.norm(middles, axis=1), 1.0)
    mirror = middles * np.array([-1.0, -1.0, 1.0])
    theta_h, _, _ = half_diff_from_directions(mirror, middles)
    np.testing.assert_allclose(theta_h, 0.0, atol=1e-9)


def test_a_matrix_by_rows_is_the_transpose(tmp_path: Path) -> None:
    path = tmp_path / "a.xml"
    brdfit.write_table(tiny_table(channels=1), path, format="klems")
    columns = brdfit.read_samples(path).value.reshape(145, 145)
    path.write_text(path.read_text().replace(">Columns<", ">Rows<"))
    np.testing.assert_array_equal(brdfit.read_samples(path).value.reshape(145, 145), columns.T)


def test_a_diffuse_material_stays_diffuse(tmp_path: Path) -> None:
    grid = Grid(8, 8, 8)
    table = Table(np.full(grid.shape, 0.2), grid=grid)
    for name in ("klems", "tensortree"):
        brdfit.write_table(table, tmp_path / "a.xml", format=name)
        value = brdfit.read_samples(tmp_path / "a.xml").value
        np.testing.assert_allclose(value, 0.2, rtol=1e-6)


def test_what_cannot_be_held_is_refused_or_said(tmp_path: Path) -> None:
    grid = Grid(4, 4, 6)
    bands = Table(np.ones((*grid.shape, 5)), grid=grid)
    for name in ("klems", "tensortree"):
        with pytest.raises(UsageError, match="5 channels"):
            brdfit.write_table(bands, tmp_path / "a.xml", format=name)
    with pytest.warns(DataQualityWarning, match="colour is lost"):
        brdfit.write_table(tiny_table(), tmp_path / "a.xml", format="tensortree")
    with pytest.warns(DataQualityWarning, match="below zero"):
        brdfit.write_table(
            Table(np.full(grid.shape, -1.0), grid=grid), tmp_path / "a.xml", format="klems"
        )


# In a process of its own: its binding falls over at the second file.
RADIANCE = """
import json, sys
from pyradiance import bsdf
loaded = bsdf.load_file(sys.argv[1])
rows = [list(map(float, bsdf.query(loaded, *row))) for row in json.load(sys.stdin)]
print(json.dumps(rows))
"""
CASES = [("tensortree", 1, 0.01), ("klems", 1, 0.05), ("klems", 3, 0.05)]


@pytest.mark.parametrize(("name", "channels", "median"), CASES)
@pytest.mark.skipif(find_spec("pyradiance") is None, reason="pyradiance is not installed")
def test_radiance_itself_reads_the_same_values(
    name: str, channels: int, median: float, tmp_path: Path
) -> None:
    table = tiny_table(Grid(20, 20, 36), channels)
    path = tmp_path / "a.xml"
    brdfit.write_table(table, path, format=name)
    rng = np.random.default_rng(0)
    theta, phi = rng.uniform(0.05, 1.2, (2, 300)), rng.uniform(-np.pi, np.pi, (2, 300))
    angles = np.rad2deg([theta[0], phi[0], theta[1], phi[1]]).T
    done = subprocess.run(
        [sys.executable, "-c", RADIANCE, str(path)],
        input=json.dumps(angles.tolist()),
        capture_output=True,
        text=True,
        check=True,
    )
    xyz = np.array(json.loads(done.stdout))
    got = xyz if channels == 3 else xyz[:, 1:2]

    def expected(azimuth: np.ndarray) -> np.ndarray:
        wi, wo = directions_from_spherical(theta, azimuth)
        value = table.evaluate(wi, wo)
        return xyz_from_linear_rgb(value) if channels == 3 else value

    off = np.median(np.abs(np.log(got / expected(phi))))
    assert off < median
    # and not those of the mirror image
    assert np.median(np.abs(np.log(got / expected(-phi)))) > 1.5 * off
