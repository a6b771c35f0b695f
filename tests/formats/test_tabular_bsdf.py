"""The two text formats named `.bsdf`: Zemax about the specular direction, LightTools the normal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, DataQualityWarning, FormatError, UsageError
from brdfit.formats.xyz import linear_rgb_from_xyz, xyz_from_linear_rgb
from brdfit.grid import Grid
from brdfit.samples import Flag, Samples
from brdfit.table import Table
from brdfit.tone import LUMINANCE

from small_files import tiny_table

pytestmark = pytest.mark.filterwarnings("ignore:.*usable|.*used:brdfit.errors.DataQualityWarning")

ZEMAX = """# a comment
Source\tMeasured
Symmetry\tPlaneSymmetrical
SpectralContent\tMonochrome
ScatterType\tBRDF
SampleRotation\t1
0
AngleOfIncidence\t2
30 60
ScatterAzimuth\t3
0 90 180
ScatterRadial\t3
0 30 60

Monochrome
DataBegin
TIS 0.5
1.0 0.5 0.25
1.0 0.4 0.2
1.0 0.3 0.0
TIS 0.6
2.0 0.9 0.8
2.0 0.7 0.6
2.0 0.0 0.0
DataEnd
"""

LIGHTTOOLS = """# a comment
Symmetry Asymmetric
SpectralContent Monochrome
ScatterAzimuth 3
0 90 270
ScatterRadial 3
0 30 60
DataBegin
AOI 30
POI 0
Side Front
Wavelength 550
ScatterType BRDF
TIS 0.5
0.1 0.2 0.3
0.1 0.4 0.5
0.1 0.9 0.7
AOI 30
POI 0
Side Front
Wavelength 450
ScatterType BRDF
TIS 0.5
1.1 1.2 1.3
1.1 1.4 1.5
1.1 1.9 1.7
AOI 30
POI 0
Side Back
Wavelength 450
ScatterType BRDF
TIS 0.5
0 0 0
0 0 0
0 0 0
DataEnd
"""


def put(folder: Path, text: str) -> Path:
    path = folder / "a.bsdf"
    path.write_text(text)
    return path


def read(folder: Path, text: str, **options: object) -> Samples:
    return brdfit.read_samples(put(folder, text), **options)


def test_content_tells_the_three_formats_of_the_suffix_apart(tmp_path: Path) -> None:
    assert read(tmp_path, ZEMAX).source.format == "zemax"
    assert read(tmp_path, LIGHTTOOLS).source.format == "lighttools"
    claims = [
        s.name for s in brdfit.list_formats() if s.sniff(Path("a.bsdf"), b"tensor_file\0\1\0")
    ]
    assert claims == ["rgl"]


def test_zemax_counts_from_the_specular_direction(tmp_path: Path) -> None:
    samples = read(tmp_path, ZEMAX)
    theta_i = np.rad2deg(np.arccos(samples.wi[:, 2])).reshape(2, 3, 3)
    np.testing.assert_allclose(theta_i, np.array([30.0, 60.0])[:, None, None] * np.ones((1, 3, 3)))
    theta_h = samples.half_diff[0].reshape(2, 3, 3)
    np.testing.assert_allclose(theta_h[:, :, 0], 0.0, atol=1e-7)
    wo = samples.wo.reshape(2, 3, 3, 3)
    # azimuth 0, radial 30 at incidence 30: from the specular direction to the normal
    np.testing.assert_allclose(wo[0, 0, 1], [0.0, 0.0, 1.0], atol=1e-12)
    # azimuth 180: away from the normal, to the horizon
    np.testing.assert_allclose(wo[0, 2, 2], [1.0, 0.0, 0.0], atol=1e-12)
    assert samples.value.reshape(2, 3, 3)[0, 1, 1] == 0.4


def test_zeros_and_copies_are_flagged_and_counted(tmp_path: Path) -> None:
    samples = read(tmp_path, ZEMAX)
    rejected = ((samples.bits & int(Flag.REJECTED)) != 0).reshape(2, 3, 3)
    assert rejected[:, 1:, 0].all()
    assert not rejected[:, 0, 0].any()
    assert rejected[0, 2, 2]
    assert rejected[1, 2, 1:].all()
    assert rejected.sum() == 4 + 3
    assert [note[:1] for note in samples.source.notes] == ["3", "4"]
    kept = read(tmp_path, ZEMAX, zeros="measured")
    assert (kept.bits & int(Flag.REJECTED)).astype(bool).sum() == 4


def test_zemax_colour_is_xyz_and_becomes_linear_rgb(tmp_path: Path) -> None:
    rgb = np.array([0.3, 0.2, 0.1])
    block = ZEMAX.split("DataBegin\n")[1].split("DataEnd")[0]
    text = ZEMAX.split("\nMonochrome\n")[0].replace("Monochrome", "XYZ")
    for axis, value in zip("XYZ", xyz_from_linear_rgb(rgb), strict=True):
        rows = "\n".join(
            line if line.startswith("TIS") else " ".join([f"{value:.9f}"] * 3)
            for line in block.strip().splitlines()
        )
        text += f"\nTristimulus{axis}\nDataBegin\n{rows}\nDataEnd\n"
    samples = read(tmp_path, text)
    assert samples.channels == ("R", "G", "B")
    np.testing.assert_allclose(samples.value, np.tile(rgb, (18, 1)), atol=1e-8)


def test_the_matrix_agrees_with_the_luminance_of_the_project() -> None:
    colours = np.eye(3)
    np.testing.assert_allclose(xyz_from_linear_rgb(colours)[:, 1], LUMINANCE)
    np.testing.assert_allclose(
        linear_rgb_from_xyz(xyz_from_linear_rgb(colours)), colours, atol=1e-12
    )


def test_a_btdf_and_damaged_headers_say_what_was_expected(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="BTDF"):
        read(tmp_path, ZEMAX.replace("BRDF", "BTDF"))
    for old, new, match in (
        ("ScatterRadial\t3", "ScatterRadial\t4", "line 15.*4 numbers|none"),
        ("ScatterRadial\t3", "ScatterRadial\t1e12", "announces 1e\\+12"),
        ("30 60\n", "30 95\n", "0 to 90"),
        ("PlaneSymmetrical", "Round", "Symmetry is 'Round'"),
        ("1.0 0.4 0.2", "1.0 0.4", "a word among them is none|TIS"),
        ("ScatterRadial\t3\n0 30 60\n", "", "ScatterRadial is missing"),
        ("2.0 0.0 0.0\nDataEnd\n", "", "truncated"),
    ):
        with pytest.raises(CorruptFile, match=match):
            read(tmp_path, ZEMAX.replace(old, new))
    with pytest.raises(UsageError, match="zeros"):
        read(tmp_path, ZEMAX, zeros="no")


def test_lighttools_has_the_light_at_azimuth_90_and_blocks_as_channels(tmp_path: Path) -> None:
    samples = read(tmp_path, LIGHTTOOLS)
    assert samples.wavelengths is not None
    assert samples.wavelengths.tolist() == [450.0, 550.0]
    assert samples.value.shape == (9, 2)
    np.testing.assert_allclose(samples.wi[0], [0.0, 0.5, np.sqrt(0.75)], atol=1e-12)
    # the mirror direction is at azimuth 270, radial 30
    mirror = int(np.argmin(samples.half_diff[0]))
    assert samples.value[mirror].tolist() == [1.9, 0.9]
    assert "1 blocks of transmission or the back" in samples.source.notes[0]
    turned = read(tmp_path, LIGHTTOOLS, light_azimuth=0.0)
    np.testing.assert_allclose(turned.wi[0], [0.5, 0.0, np.sqrt(0.75)], atol=1e-12)


def test_lighttools_blocks_that_do_not_fit_are_told(tmp_path: Path) -> None:
    for old, new, match in (
        ("Wavelength 450", "Wavelength 550", "two blocks have AOI 30"),
        ("0.1 0.2 0.3\n", "0.1 0.2 0.3 0.4\n", "one of AOI, POI|none"),
        ("Side Front", "Side Left", "Front, Back"),
        ("ScatterRadial 3\n0 30 60\n", "", "missing: radial"),
        ("AOI 30", "AOI 130", "AOI 130"),
    ):
        with pytest.raises(CorruptFile, match=match):
            read(tmp_path, LIGHTTOOLS.replace(old, new))
    with pytest.raises(FormatError, match="none of its 3 blocks"):
        read(tmp_path, LIGHTTOOLS.replace("Front", "Back"))


def test_writing_says_whether_the_material_mirrors_itself(tmp_path: Path) -> None:
    path = tmp_path / "a.bsdf"
    brdfit.write_table(tiny_table(channels=1), path, format="zemax")
    assert "Asymmetrical" in path.read_text()
    grid = Grid(4, 4, 6)
    brdfit.write_table(Table(np.full(grid.shape, 0.2), grid=grid), path, format="zemax")
    assert "PlaneSymmetrical" in path.read_text()


def test_the_total_of_a_diffuse_material_is_its_albedo(tmp_path: Path) -> None:
    path, grid = tmp_path / "a.bsdf", Grid(8, 8, 8)
    brdfit.write_table(Table(np.full(grid.shape, 0.5 / np.pi), grid=grid), path, format="zemax")
    totals = [float(line.split()[1]) for line in path.read_text().splitlines() if "TIS" in line]
    np.testing.assert_allclose(totals, 0.5, rtol=0.02)


def test_what_zemax_cannot_hold_is_refused_or_counted(tmp_path: Path) -> None:
    grid = Grid(4, 4, 6)
    with pytest.raises(UsageError, match="5 channels"):
        brdfit.write_table(
            Table(np.ones((*grid.shape, 5)), grid=grid), tmp_path / "a.bsdf", format="zemax"
        )
    with pytest.warns(DataQualityWarning, match="below zero were written as 0"):
        brdfit.write_table(
            Table(np.full(grid.shape, -1.0), grid=grid), tmp_path / "a.bsdf", format="zemax"
        )
    nothing = Table(np.ones(grid.shape), grid=grid, valid=np.zeros(grid.shape, bool))
    with pytest.raises(UsageError, match="no valid cell"):
        brdfit.write_table(nothing, tmp_path / "b.bsdf", format="zemax")


def test_lighttools_has_the_specular_direction_opposite_the_light(tmp_path: Path) -> None:
    path, grid = tmp_path / "a.bsdf", Grid(8, 8, 8)
    lobe = np.exp(-8.0 * grid.theta_h**2)[:, None, None] * np.ones(grid.shape)
    brdfit.write_table(Table(lobe, grid=grid), path, format="lighttools")
    samples = brdfit.read_samples(path)
    assert samples.source.format == "lighttools"
    oblique = samples.subset(np.isclose(samples.wi[:, 2], np.cos(np.deg2rad(40.0))))
    peak = int(np.argmax(oblique.value[:, 0]))
    np.testing.assert_allclose(oblique.wi[peak, :2], -oblique.wo[peak, :2], atol=1e-9)
    assert "SpectralContent Monochrome" in path.read_text()
    assert "Symmetry Asymmetric" in path.read_text()


def test_the_total_of_lighttools_is_the_albedo(tmp_path: Path) -> None:
    path, grid = tmp_path / "a.bsdf", Grid(8, 8, 8)
    flat = Table(np.full(grid.shape, 0.5 / np.pi), grid=grid)
    brdfit.write_table(flat, path, format="lighttools")
    totals = [float(line.split()[1]) for line in path.read_text().splitlines() if "TIS" in line]
    np.testing.assert_allclose(totals, 0.5, rtol=0.005)
