"""A panorama as distant lights: the environment map of a user, for everything that takes lights.

A latitude-longitude picture is cut into blocks of equal angles. Each becomes one light in the
direction of its luminance-weighted middle, with the irradiance of all its pixels: no light is
lost, and a small sun stays where it is. The middle column is what the viewer's back is turned
to, the top row is up.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray, normalize
from brdfit.errors import UsageError
from brdfit.render.illumination import Illumination
from brdfit.tone import LUMINANCE

__all__ = ["panorama_lights"]

_ROWS = 12


def panorama_lights(image: FloatArray, name: str = "panorama", rows: int = _ROWS) -> Illumination:
    """Return at most 2 rows^2 lights of a panorama (height, width, 3), linear sRGB radiance.

    View coordinates: x right, y up, z toward the viewer; the middle of the picture lies at -z.
    Values below zero and those that are not finite count as zero. Raises `UsageError` for
    what is no panorama, or is black.
    """
    image = np.asarray(image, dtype=np.float64)
    if image.ndim != 3 or image.shape[2] != 3 or min(image.shape[:2]) < 2 * rows:
        raise UsageError(
            f"{name}: found a picture of shape {image.shape} but a panorama has three channels and "
            f"at least {2 * rows} pixels along each side."
        )
    radiance = np.where(np.isfinite(image), np.maximum(image, 0.0), 0.0)
    height, width = radiance.shape[:2]
    direction, solid_angle = _pixels(height, width)
    power = radiance * solid_angle[:, None, None]
    block = _blocks(height, rows)[:, None] * 2 * rows + _blocks(width, 2 * rows)[None, :]
    count = 2 * rows * rows
    weight = power @ np.asarray(LUMINANCE)
    middle = _sums(block, weight[..., None] * direction, count)
    irradiance = _sums(block, power, count)
    lit = (irradiance.sum(axis=1) > 0.0) & (np.abs(middle).sum(axis=1) > 0.0)
    if not lit.any():
        raise UsageError(f"{name}: the panorama is black; nothing would be seen.")
    return Illumination(name, normalize(middle[lit]), irradiance[lit])


def _pixels(height: int, width: int) -> tuple[FloatArray, FloatArray]:
    """Return (directions (height, width, 3), solid angle of a pixel of each row (height,))."""
    edge = np.linspace(0.0, np.pi, height + 1)
    theta = 0.5 * (edge[1:] + edge[:-1])
    phi = ((np.arange(width) + 0.5) / width - 0.5) * 2.0 * np.pi
    sine = np.sin(theta)[:, None]
    x, y, z = sine * np.sin(phi), np.cos(theta)[:, None] + 0.0 * phi, -sine * np.cos(phi)
    solid_angle = -np.diff(np.cos(edge)) * 2.0 * np.pi / width
    return np.stack([x, y, z], axis=-1), solid_angle


def _blocks(size: int, count: int) -> FloatArray:
    return np.asarray(np.arange(size) * count // size)


def _sums(block: FloatArray, values: FloatArray, count: int) -> FloatArray:
    flat = block.reshape(-1)
    columns = [np.bincount(flat, column, count) for column in values.reshape(-1, 3).T]
    return np.stack(columns, axis=1)
