"""A user's environment map on its way to the page."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from brdfit.errors import DataQualityWarning
from brdfit.tone import srgb_decode
from brdfit.viewer.environment import read_panorama
from brdfit.viewer.workbench import Workbench

from viewer_client import Client


def png(level: int, size: tuple[int, int] = (96, 48)) -> bytes:
    """Return an even grey picture."""
    from PIL import Image

    content = io.BytesIO()
    Image.new("RGB", size, (level, level, level)).save(content, format="png")
    return content.getvalue()


def test_a_picture_becomes_lights_and_the_file_goes(ask: Client, bench: Workbench) -> None:
    answer = ask("api/environments?name=sky.png", "POST", png(128))
    assert answer.json["name"] == "sky.png"
    total = np.sum(answer.json["irradiance"], axis=0)
    np.testing.assert_allclose(total, 4.0 * np.pi * srgb_decode(np.array(128 / 255)), rtol=1e-6)
    assert list(bench.store.folder.iterdir()) == []


def test_a_panorama_in_exr_is_read(shared_data: Path) -> None:
    pytest.importorskip("OpenEXR", reason="extra exr")
    with pytest.warns(DataQualityWarning, match="pixels are negative"):
        image = read_panorama(shared_data / "environments" / "studio.exr")
    assert image.shape == (256, 512, 3)
    assert image.max() > 1.0


def radiance(level: float, size: tuple[int, int] = (96, 48), claimed: int = 0) -> bytes:
    """Return an even grey in Radiance's flat RGBE, mantissa 128 + 1/2 of an exponent."""
    width, height = size
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {claimed or height} +X {width}\n".encode()
    exponent = 129 + round(np.log2(level))
    return head + bytes([128, 128, 128, exponent]) * (width * height)


def test_a_panorama_in_radiance_hdr_becomes_lights_brighter_than_a_screen(
    ask: Client, bench: Workbench
) -> None:
    answer = ask("api/environments?name=sky.hdr", "POST", radiance(8.0))
    total = np.sum(answer.json["irradiance"], axis=0)
    np.testing.assert_allclose(total, 4.0 * np.pi * 8.0 * (128.5 / 128), rtol=1e-6)
    assert answer.json["warnings"] == []
    assert list(bench.store.folder.iterdir()) == []


def test_what_a_panorama_lacks_is_said(ask: Client) -> None:
    answer = ask("api/environments?name=wide.hdr", "POST", radiance(1.0, (100, 48)))
    assert "100 x 48" in answer.json["warnings"][0]


def test_a_panorama_that_claims_absurd_pixels_is_refused(ask: Client, bench: Workbench) -> None:
    answer = ask("api/environments?name=sky.hdr", "POST", radiance(1.0, claimed=900_000))
    assert answer.code == 422
    assert "96 x 900000" in answer.json["message"]
    assert list(bench.store.folder.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("sky.png", b"\x89PNG\r\n\x1a\nbroken", 422),
        ("sky.exr", b"v/1\x01broken", 422),
        ("sky.hdr", b"#?RADIANCE\n\n-Y 48 +X 96\nbroken", 422),
        ("sky.tiff", b"II*\0", 422),
        ("sky.png", png(0), 400),
    ],
    ids=["png", "exr", "hdr", "tiff", "black"],
)
def test_what_is_no_panorama_is_refused_and_leaves_nothing(
    ask: Client, bench: Workbench, name: str, content: bytes, code: int
) -> None:
    answer = ask(f"api/environments?name={name}", "POST", content)
    assert answer.code == code
    assert name in answer.json["message"]
    assert list(bench.store.folder.iterdir()) == []
