"""Pictures within the page: rendered spheres and maps as PNG in a data address."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import UsageError
from brdfit.progress import Progress, silent
from brdfit.render import ILLUMINATIONS, Sphere
from brdfit.report.rgb import rgb_table
from brdfit.table import Table
from brdfit.tone import display_image, exposure_scale

__all__ = ["LIGHTS", "SphereRow", "cut_out", "png_uri", "sphere_rows"]

LIGHTS = {"area_studio": "three area lights and a dim surround", "point": "one point light"}
"""Illumination -> what it is, in words."""

_SIZE = 220


@dataclass(frozen=True)
class SphereRow:
    """The same sphere under each of `LIGHTS`."""

    title: str
    pictures: tuple[tuple[str, str], ...]
    """(light in words, data address); the address is empty where there is nothing to see."""


def png_uri(rgba: FloatArray) -> str:
    """Return (height, width, 4) in [0, 1] as an 8-bit PNG in a data address."""
    from matplotlib.image import imsave

    stream = io.BytesIO()
    imsave(stream, np.ascontiguousarray(rgba.clip(0.0, 1.0)), format="png", metadata={})
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def sphere_rows(
    table: Table, reference: Table | None = None, progress: Progress = silent
) -> list[SphereRow]:
    """Return the spheres of `table`, and of a reference above it under the same exposure."""
    sphere = Sphere(_SIZE)
    named = [("Reference", reference)] if reference is not None else []
    named.append(("Reconstruction", table))
    shown = [(title, rgb_table(one)[0]) for title, one in named if one is not None]
    pictures: dict[str, list[tuple[str, str]]] = {title: [] for title, _ in shown}
    progress("spheres", 0, len(LIGHTS))
    for done, (name, words) in enumerate(LIGHTS.items()):
        linear = {title: sphere.shade(rgb, ILLUMINATIONS[name]()) for title, rgb in shown}
        scale = _exposure(next(iter(linear.values())), sphere.mask)
        for title, image in linear.items():
            uri = "" if scale is None else png_uri(cut_out(display_image(image, scale)))
            pictures[title].append((words, uri))
        progress("spheres", done + 1, len(LIGHTS))
    return [SphereRow(title, tuple(found)) for title, found in pictures.items()]


def _exposure(linear: FloatArray, mask: BoolArray) -> float | None:
    try:
        return exposure_scale(linear, mask)
    except UsageError:
        return None


def cut_out(display: FloatArray) -> FloatArray:
    """Return (size, size, 4): opaque on the disk, its edge smooth, nothing beside it."""
    size = len(display)
    middle = (2.0 * np.arange(size) + 1.0) / size - 1.0
    radius = np.hypot(middle[:, None], middle)
    alpha = np.clip((1.0 - radius) * size / 2.0 + 0.5, 0.0, 1.0)
    return np.concatenate([display, alpha[..., None]], axis=2)
