"""A user's environment map on its way to the page."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

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
    image = read_panorama(shared_data / "environments" / "studio.exr")
    assert image.shape == (256, 512, 3)
    assert image.max() > 1.0


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("sky.png", b"\x89PNG\r\n\x1a\nbroken", 422),
        ("sky.exr", b"v/1\x01broken", 422),
        ("sky.tiff", b"II*\0", 400),
        ("sky.png", png(0), 400),
    ],
    ids=["png", "exr", "tiff", "black"],
)
def test_what_is_no_panorama_is_refused_and_leaves_nothing(
    ask: Client, bench: Workbench, name: str, content: bytes, code: int
) -> None:
    answer = ask(f"api/environments?name={name}", "POST", content)
    assert answer.code == code
    assert name in answer.json["message"]
    assert list(bench.store.folder.iterdir()) == []
