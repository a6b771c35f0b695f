"""A picture as a PNG file."""

from __future__ import annotations

from pathlib import Path

from brdfit.arrays import FloatArray
from brdfit.files import atomic_path

__all__ = ["write_picture"]


def write_picture(display: FloatArray, path: Path) -> None:
    """Write (height, width, 3) in [0, 1], the sRGB curve already on it, as 8-bit PNG."""
    from matplotlib.image import imsave

    with atomic_path(path) as aside:
        imsave(aside, display.clip(0.0, 1.0), format="png")
