"""Environment maps from files, and spheres on a sheet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from brdfit.errors import BrdfitError, CorruptFile, DataQualityWarning, UnknownFormat
from brdfit.formats.exr_file import write_exr
from brdfit.report.contact_sheet import write_contact_sheet
from brdfit.report.environment_file import read_environment

HEADER = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n"


def flat() -> bytes:
    """16 x 8 pixels, pixel k of red k, exponent of 1."""
    return HEADER + b"".join(bytes([k, 64, 128, 129]) for k in range(128))


def packed() -> bytes:
    """The same, run by run."""
    rows = b""
    for row in range(8):
        rows += bytes([2, 2, 0, 16]) + bytes([16, *range(16 * row, 16 * row + 16)])
        rows += bytes([128 + 16, 64, 128 + 10, 128, 128 + 6, 128, 128 + 16, 129])
    return HEADER + rows


@pytest.mark.parametrize("content", [flat(), packed()], ids=["flat", "packed"])
def test_hdr_holds_mantissas_and_an_exponent(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "a.hdr").write_bytes(content)
    radiance = read_environment(tmp_path / "a.hdr").radiance
    assert radiance.shape == (8, 16, 3)
    red = (np.arange(128).reshape(8, 16) + 0.5) / 128.0
    np.testing.assert_allclose(radiance[..., 0], red)
    np.testing.assert_allclose(
        radiance[..., 1:], np.broadcast_to([64.5 / 128, 128.5 / 128], (8, 16, 2))
    )


@pytest.mark.parametrize("content", [flat(), packed()], ids=["flat", "packed"])
def test_a_broken_hdr_says_so_wherever_it_ends(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.hdr"
    for length in range(len(content)):
        path.write_bytes(content[:length])
        with pytest.raises(BrdfitError):
            read_environment(path)


def test_exr_is_read_and_what_is_no_light_is_counted(tmp_path: Path) -> None:
    pytest.importorskip("OpenEXR", reason="the extra 'exr' is not installed")
    plane = np.arange(32.0).reshape(4, 8)
    red = plane.copy()
    red[0, :3] = [-1.0, np.nan, np.inf]
    write_exr({"R": red, "G": plane, "B": plane}, {}, tmp_path / "a.exr")
    with pytest.warns(DataQualityWarning, match="3 of 32 pixels"):
        environment = read_environment(tmp_path / "a.exr", 90.0)
    assert environment.radiance[0, :3, 0].tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_array_equal(environment.radiance[1:, :, 0], plane[1:])
    assert environment.turned == pytest.approx(np.pi / 2)


def test_a_broken_exr_says_so(tmp_path: Path) -> None:
    pytest.importorskip("OpenEXR", reason="the extra 'exr' is not installed")
    path = tmp_path / "a.exr"
    write_exr({name: np.ones((4, 8)) for name in "RGB"}, {}, path)
    content = path.read_bytes()
    for length in (5, 40, len(content) // 2, len(content) - 3):
        path.write_bytes(content[:length])
        with pytest.raises(CorruptFile):
            read_environment(path)


def test_another_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.exr").write_bytes(b"GIF89a")
    with pytest.raises(UnknownFormat, match="neither OpenEXR nor Radiance"):
        read_environment(tmp_path / "a.exr")


def test_the_shared_panoramas_are_read(shared_data: Path) -> None:
    pytest.importorskip("OpenEXR", reason="the extra 'exr' is not installed")
    with pytest.warns(DataQualityWarning, match="negative"):
        environment = read_environment(shared_data / "environments" / "city.exr")
    assert environment.shape == (256, 512)


def test_a_sheet_holds_every_sphere_at_its_size(tmp_path: Path) -> None:
    from matplotlib.image import imread

    colours = [*np.eye(3).tolist(), [1.0, 1.0, 0.0]]
    pictures = [(f"no_{k}$_x^", np.broadcast_to(c, (40, 40, 3))) for k, c in enumerate(colours)]
    write_contact_sheet(pictures, tmp_path / "sheet.png", columns=3)
    sheet = imread(tmp_path / "sheet.png")[..., :3]
    assert sheet.shape == (8 + 2 * 70, 8 + 3 * 48, 3)
    for k, colour in enumerate(colours):
        top, left = 8 + k // 3 * 70, 8 + k % 3 * 48
        np.testing.assert_allclose(
            sheet[top : top + 40, left : left + 40].mean(axis=(0, 1)), colour
        )
        assert sheet[top + 42 : top + 60, left : left + 40].max() > 0.5, "no label"


def test_a_signalling_nan_is_counted_like_any_other(tmp_path: Path) -> None:
    pytest.importorskip("OpenEXR", reason="the extra 'exr' is not installed")
    plane = np.ones((4, 8), dtype=np.float32)
    plane.view(np.uint32)[2, 3] = 0x7FA00000
    write_exr(dict.fromkeys("RGB", plane), {}, tmp_path / "a.exr")
    with pytest.warns(DataQualityWarning, match="1 of 32 pixels are negative or not finite"):
        environment = read_environment(tmp_path / "a.exr")
    assert environment.radiance[2, 3, 0] == 0.0
