"""UTIA's `.bin`: where each number stands, what it means, and that nothing is made isotropic."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import CorruptFile, UsageError
from brdfit.formats.sheet import HEAD_BYTES
from brdfit.samples import Samples

from small_files import utia_numbers

pytestmark = pytest.mark.filterwarnings("ignore::brdfit.errors.ConventionWarning")


def put(folder: Path, numbers: np.ndarray, kind: str = "<f8", name: str = "m001.bin") -> Path:
    path = folder / name
    path.write_bytes(numbers.astype(kind).tobytes())
    return path


@pytest.fixture
def samples(tmp_path: Path) -> Samples:
    return brdfit.read_samples(put(tmp_path, utia_numbers()))


def test_every_number_has_the_directions_of_its_place(samples: Samples) -> None:
    assert samples.source.format == "utia"
    assert len(samples) == 82_944
    # as its readers compute the place: 288 (48 theta_i + phi_i) + 48 theta_v + phi_v
    theta_i, phi_i, theta_v, phi_v = 3, 10, 4, 17
    row = 288 * (48 * theta_i + phi_i) + 48 * theta_v + phi_v
    theta, phi = np.deg2rad([15.0 * theta_i, 15.0 * theta_v]), np.deg2rad([75.0, 127.5])
    wi, wo = brdfit.directions_from_spherical(theta, phi)
    np.testing.assert_allclose(samples.wi[row], wi, atol=1e-12)
    np.testing.assert_allclose(samples.wo[row], wo, atol=1e-12)
    expected = utia_numbers()[:, theta_i, phi_i, theta_v, phi_v]
    np.testing.assert_array_equal(samples.value[row], expected)
    assert samples.rows is not None
    assert samples.rows[row] == row + 1


def test_single_precision_is_told_by_the_size(samples: Samples, tmp_path: Path) -> None:
    single = brdfit.read_samples(put(tmp_path, utia_numbers(), "<f4", "single.bin"))
    np.testing.assert_allclose(single.value, samples.value, rtol=1e-6)


def test_the_content_tells_the_format_whatever_the_suffix(tmp_path: Path) -> None:
    path = put(tmp_path, utia_numbers(), name="m001.dat")
    assert brdfit.read_samples(path, count=50).source.format == "utia"
    text = tmp_path / "text.bin"
    text.write_text(("0.25 0.5 0.75 1.00 " * 60_000)[:995_328])
    (sheet,) = (sheet for sheet in brdfit.list_formats() if sheet.name == "utia")
    assert sheet.sniff(path, path.read_bytes()[:HEAD_BYTES])
    assert not sheet.sniff(text, text.read_bytes()[:HEAD_BYTES])


def test_the_curve_of_srgb_is_undone_where_it_is_asked_for(tmp_path: Path) -> None:
    numbers = np.full((3, 6, 48, 6, 48), 70.0)
    numbers[1], numbers[2] = 1.4, -70.0
    path = put(tmp_path, numbers)
    got = brdfit.read_samples(path, encoding="srgb", white=140, scale=100, count=20).value[0]
    # 70/140 = 0.5 is 0.21404 linear; 0.01 lies on the straight part; what is negative stays so
    np.testing.assert_allclose(got, [21.404, 100 * 0.01 / 12.92, -21.404], rtol=1e-4)


def test_the_meaning_of_the_numbers_is_said(samples: Samples, tmp_path: Path) -> None:
    assert "does not say the unit" in samples.source.notes[0]
    said = brdfit.read_samples(put(tmp_path, utia_numbers()), scale=0.5, count=20).source.notes
    assert "0.5 times" in said[0]
    assert "20 of 82,944" in said[2]


def test_how_anisotropic_the_material_is_stands_in_a_note(tmp_path: Path) -> None:
    def note(numbers: np.ndarray) -> str:
        return brdfit.read_samples(put(tmp_path, numbers), count=20).source.notes[1]

    phi = np.arange(48) * np.pi / 24
    turn = np.cos(phi[:, None] - phi[None, :])[None, None, :, None, :]
    same = np.broadcast_to(0.5 + 0.2 * turn, (3, 6, 48, 6, 48))
    assert "by 0% (median)" in note(same)
    brushed = same * np.exp(0.5 * np.cos(2 * phi))[None, None, :, None, None]
    # the standard deviation of 0.5 cos is 0.5 / sqrt 2
    assert "by 35% (median)" in note(brushed)
    assert "an unknown amount" in note(-same)


def test_a_draw_is_the_same_for_a_seed_and_keeps_its_rows(tmp_path: Path) -> None:
    path = put(tmp_path, utia_numbers())
    whole = brdfit.read_samples(path)
    one, two = (brdfit.read_samples(path, count=100, seed=seed) for seed in (3, 4))
    assert one.rows is not None
    np.testing.assert_array_equal(one.value, whole.value[one.rows - 1])
    assert not np.array_equal(one.rows, two.rows)


def test_what_cannot_be_is_named(tmp_path: Path) -> None:
    path = put(tmp_path, utia_numbers())
    cut = tmp_path / "cut.bin"
    cut.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(CorruptFile, match=r"1,990,648 bytes but .* 1,990,656 \(float64\)"):
        brdfit.read_samples(cut)
    for option, match in (
        ({"encoding": "gamma"}, "'gamma' but one of linear, srgb"),
        ({"white": 0}, "white: found 0"),
        ({"scale": "x"}, "scale: found 'x'"),
        ({"count": 0}, "82,944 pairs of directions .* count is 0"),
    ):
        with pytest.raises(UsageError, match=match):
            brdfit.read_samples(path, **option)
