"""RT-300S workbooks: the blank, the obscured directions, the geometry, real files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import BrdfitWarning, CorruptFile, FormatError, NotThisFormat, UsageError
from brdfit.formats.rt300s import SHEET
from brdfit.samples import Flag, Samples

from small_workbook import Cell, workbook

pytest.importorskip("xlrd")
pytestmark = pytest.mark.filterwarnings(f"ignore::{BrdfitWarning.__module__}.BrdfitWarning")

Columns = Sequence[tuple[float, float, float, Cell]]
ANGLES = [(-90.0, 30.0, 30.0), (-90.0, 30.0, -30.0), (0.0, 30.0, 60.0), (90.0, 30.0, -30.0)]
COLUMNS = [(*of, 0.1 * (k + 1)) for k, of in enumerate(ANGLES)]


def put(folder: Path, name: str, columns: Columns, split: int = 100) -> Path:
    """Write a workbook whose sheets hold `split` columns each."""
    labels = (" Azimuth", " Incidence", " Receive", " RT")
    sheets = [
        [[" Method", *["BRDF_LD"] * len(part)]]
        + [[label, *(column[k] for column in part)] for k, label in enumerate(labels)]
        for part in (columns[start : start + split] for start in range(0, len(columns), split))
    ]
    path = folder / name
    path.write_bytes(workbook(sheets))
    return path


def read(path: Path, **options: object) -> Samples:
    return brdfit.read_samples(path, **options)


def test_the_blank_is_subtracted_and_the_cosine_of_the_detector_divided_away(
    tmp_path: Path,
) -> None:
    put(tmp_path, "blank.xls", [(*of, 0.01) for of in ANGLES])
    samples = read(put(tmp_path, "a.xls", COLUMNS))
    receive = np.deg2rad([30.0, -30.0, 60.0, -30.0])
    expected = (np.array([0.1, 0.2, 0.3, 0.4]) - 0.01) / (np.pi * np.cos(receive))
    np.testing.assert_allclose(samples.value[:, 0], expected)
    assert any("blank subtracted: blank.xls" in note for note in samples.source.notes)
    assert samples.source.metadata["Method"] == "BRDF_LD"


def test_the_specular_direction_is_at_azimuth_minus_90(tmp_path: Path) -> None:
    samples = read(put(tmp_path, "a.xls", COLUMNS), blank=False)
    theta_h = samples.half_diff[0]
    np.testing.assert_allclose(theta_h[[0, 3]], 0.0, atol=1e-12)
    assert theta_h[1] > 0.5
    np.testing.assert_allclose(samples.wo[2], [np.sin(np.pi / 3), 0.0, 0.5], atol=1e-12)
    # out of the plane: the light stands at a right angle to the plane of the detector
    np.testing.assert_allclose(samples.wi[2], [0.0, -0.5, np.sqrt(0.75)], atol=1e-12)


def test_samples_whose_detector_stands_in_the_beam_are_rejected(tmp_path: Path) -> None:
    path = put(tmp_path, "a.xls", [*COLUMNS, (-90.0, 30.0, -23.0, 0.5)])
    samples = read(path, blank=False)
    assert samples.bits[[1, 4]].tolist() == [int(Flag.REJECTED), 0]
    assert any("1 samples rejected" in note for note in samples.source.notes)
    assert read(path, blank=False, obscured=8.0).bits[4] == int(Flag.REJECTED)
    assert read(path, blank=False, obscured=0.0).usable.all()


def test_the_blank_is_matched_by_its_angles_not_by_its_order(tmp_path: Path) -> None:
    blank = [(*of, 0.01 * (k + 1)) for k, of in enumerate(ANGLES)]
    path = put(tmp_path, "a.xls", COLUMNS, split=3)
    put(tmp_path, "blank1.xls", blank)
    put(tmp_path, "zero.xls", blank[::-1], split=2)
    np.testing.assert_array_equal(read(path).value, read(path, blank="zero.xls").value)


def test_a_direction_that_the_blank_lacks_has_no_value(tmp_path: Path) -> None:
    put(tmp_path, "blank.xls", [(*of, 0.01) for of in ANGLES[:3]])
    samples = read(put(tmp_path, "a.xls", COLUMNS))
    assert np.isnan(samples.value[:, 0]).tolist() == [False, False, False, True]
    put(tmp_path, "blank.xls", [(*of, 0.01) for of in ANGLES[:1]])
    with pytest.raises(FormatError, match="lacks 3 of its 4 pairs"):
        read(tmp_path / "a.xls")


def test_without_a_blank_it_says_what_to_do(tmp_path: Path) -> None:
    path = put(tmp_path, "a.xls", COLUMNS)
    with pytest.raises(UsageError, match=r"there is none beside it.*blank=False"):
        read(path)
    for name in ("blank_a.xls", "blank_b.xls"):
        put(tmp_path, name, COLUMNS)
    with pytest.raises(UsageError, match=r"2 \(blank_a.xls, blank_b.xls\)"):
        read(path)
    with pytest.raises(FormatError, match="no such file"):
        read(path, blank="other.xls")
    assert "no blank subtracted" in read(path, blank=False).source.notes[0]


def test_text_in_place_of_a_number_is_flagged_and_keeps_its_column(tmp_path: Path) -> None:
    samples = read(put(tmp_path, "a.xls", [*COLUMNS[:2], (0.0, 30.0, 60.0, "ovf")]), blank=False)
    assert samples.flag_counts()["not_finite"] == 1
    assert samples.rows is not None
    assert samples.rows.tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"obscured": -1.0}, "obscured"),
        ({"obscured": "x"}, "obscured"),
        ({"wavelength": 0.0}, "nm"),
    ],
)
def test_options_that_cannot_mean_anything(
    tmp_path: Path, options: dict[str, object], match: str
) -> None:
    with pytest.raises(UsageError, match=match):
        read(put(tmp_path, "a.xls", COLUMNS), blank=False, **options)


def test_another_workbook_and_a_cut_one_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "budget.xls"
    path.write_bytes(workbook([[["Month", 1.0], ["Sum", 2.0]]]))
    with pytest.raises(NotThisFormat, match="Azimuth, Incidence, Receive, RT"):
        SHEET.read_samples(path, blank=False)  # type: ignore[misc]
    whole = put(tmp_path, "a.xls", COLUMNS).read_bytes()
    path.write_bytes(whole[:2000])
    with pytest.raises(CorruptFile, match="truncated or damaged"):
        read(path, blank=False)


def test_the_real_files(shared_data: Path) -> None:
    folder = shared_data / "rt300s"
    samples = read(folder / "ANOPLATE_AnoBlack_EC1_Alum6061_v1o0_20251115.xls", wavelength=650)
    assert len(samples) == 4 * 19 * 33
    assert samples.channels == ("650nm",)
    assert samples.flag_counts() == {"rejected": 38}
    # black anodising: dark everywhere but about the specular direction at incidence 70
    assert np.median(samples.value) < 0.03
    brightest = samples.half_diff[0][np.argmax(samples.value)]
    assert np.rad2deg(brightest) < 5.1


def test_the_real_file_agrees_with_what_its_authors_made_of_it(shared_data: Path) -> None:
    """Their Zemax file is interpolated from these samples, shifted and averaged with the mirror."""
    from scipy.spatial import cKDTree

    folder = shared_data / "rt300s"
    ours = read(folder / "ANOPLATE_AnoBlack_EC1_Alum6061_v1o0_20251115.xls")
    theirs = read(folder / "AnoBlackEC1onAlum.bsdf")
    assert theirs.source.format == "zemax"
    tree = cKDTree(key(ours))
    distance, partner = tree.query(key(theirs))
    near = distance < np.deg2rad(1.5)
    assert near.sum() > 150
    value = ours.value[ours.positive[:, 0], 0][partner[near]]
    off = np.log(theirs.value[theirs.positive[:, 0], 0][near] / value)
    assert abs(np.median(off)) < 0.01
    assert np.median(np.abs(off)) < 0.06


def key(samples: Samples) -> np.ndarray:
    """Coordinates of the usable directions that ignore a turn about the normal and mirroring."""
    from brdfit.geometry import spherical_from_directions

    good = samples.positive[:, 0]
    theta_i, phi_i = spherical_from_directions(samples.wi[good])
    theta_o, phi_o = spherical_from_directions(samples.wo[good])
    apart = np.abs(np.angle(np.exp(1j * (phi_o - phi_i))))
    sin_o = np.sin(theta_o)
    return np.stack(
        [5 * theta_i, sin_o * np.cos(apart), sin_o * np.sin(apart), np.cos(theta_o)], axis=1
    )
