"""The sphere on the viewer's page, beside the one that brdfit renders: for tests and benchmarks."""

from __future__ import annotations

import io
import json

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.metrics.ciede2000 import lab_from_linear
from brdfit.render import Sphere
from brdfit.tone import colour_library, exposure_scale, srgb_decode

from chromium import Tab

__all__ = ["picture", "shown_difference", "sphere_of"]


def picture(tab: Tab) -> tuple[FloatArray, dict[str, int]]:
    """Return (the canvas as shown (height, width, 3), its first cell)."""
    from matplotlib.image import imread

    canvas = tab.page.locator("#stage canvas")
    shot = imread(io.BytesIO(canvas.screenshot()))[..., :3]
    cell = json.loads(canvas.get_attribute("data-cells"))[0]
    return np.asarray(shot, dtype=np.float64), cell


def sphere_of(tab: Tab) -> FloatArray:
    """Return the pixels that `brdfit.render.Sphere(2 radius)` would have."""
    shot, cell = picture(tab)
    radius = cell["radius"]
    # rows count from the top here, cells from the bottom there
    middle_row = shot.shape[0] - (cell["y"] + cell["centreY"])
    middle_column = cell["x"] + cell["centreX"]
    return shot[
        middle_row - radius : middle_row + radius, middle_column - radius : middle_column + radius
    ]


def shown_difference(shown: FloatArray, linear: FloatArray, sphere: Sphere) -> float:
    """Return the mean CIEDE2000 as shown and as rendered, but for a twentieth at the edge."""
    from scipy.ndimage import binary_erosion

    scale = exposure_scale(linear, sphere.mask)
    middle = binary_erosion(sphere.mask, iterations=max(1, sphere.size // 20))
    lab = [lab_from_linear(image[middle]) for image in (srgb_decode(shown), linear * scale)]
    return float(np.mean(colour_library().difference.delta_E_CIE2000(*lab)))
