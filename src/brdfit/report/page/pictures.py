"""Pictures within the page: rendered spheres and maps as PNG in a data address."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import UsageError
from brdfit.metrics import difference_map
from brdfit.progress import Progress, silent
from brdfit.render import ILLUMINATIONS, Sphere
from brdfit.report.page.words import number
from brdfit.report.rgb import rgb_table
from brdfit.table import Table
from brdfit.tone import display_image, exposure_scale

__all__ = ["LIGHTS", "MOST_DIFFERENT", "SphereRow", "cut_out", "png_uri", "sphere_rows"]

LIGHTS = {"area_studio": "three area lights and a dim surround", "point": "one point light"}
"""Illumination -> what it is, in words."""

MOST_DIFFERENT = 10.0
"""CIEDE2000 that the last colour of a difference means, and all above it."""

_SIZE = 220
# Dark blue to yellow, evenly brighter, as the viewer shows a difference.
_RAMP = np.array(
    [
        [0.267, 0.005, 0.329],
        [0.230, 0.322, 0.546],
        [0.128, 0.567, 0.551],
        [0.369, 0.789, 0.383],
        [0.993, 0.906, 0.144],
    ]
)


@dataclass(frozen=True)
class SphereRow:
    """The same sphere under each of `LIGHTS`."""

    title: str
    pictures: tuple[tuple[str, str], ...]
    """(caption, data address); the address is empty where there is nothing to see."""


def png_uri(rgba: FloatArray) -> str:
    """Return (height, width, 4) in [0, 1] as an 8-bit PNG in a data address."""
    from matplotlib.image import imsave

    stream = io.BytesIO()
    imsave(stream, np.ascontiguousarray(rgba.clip(0.0, 1.0)), format="png", metadata={})
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def sphere_rows(
    table: Table, reference: Table | None = None, progress: Progress = silent
) -> list[SphereRow]:
    """Return the spheres of `table`.

    With a reference, its own stand above under the same exposure, and below both their
    difference in CIEDE2000, from dark at 0 to yellow at `MOST_DIFFERENT`.
    """
    sphere = Sphere(_SIZE)
    named = [("Reference", reference)] if reference is not None else []
    named.append(("Reconstruction", table))
    shown = [(title, rgb_table(one)[0]) for title, one in named if one is not None]
    pictures: dict[str, list[tuple[str, str]]] = {title: [] for title, _ in shown}
    differences: list[tuple[str, str]] = []
    progress("spheres", 0, len(LIGHTS))
    for done, (name, words) in enumerate(LIGHTS.items()):
        linear = {title: sphere.shade(rgb, ILLUMINATIONS[name]()) for title, rgb in shown}
        scale = _exposure(next(iter(linear.values())), sphere.mask)
        for title, image in linear.items():
            uri = "" if scale is None else png_uri(cut_out(display_image(image, scale)))
            pictures[title].append((words, uri))
        if reference is not None and scale is not None:
            differences.append(_difference(linear, sphere.mask, words))
        progress("spheres", done + 1, len(LIGHTS))
    rows = [SphereRow(title, tuple(found)) for title, found in pictures.items()]
    return [*rows, SphereRow("Difference", tuple(differences))] if differences else rows


def _difference(linear: dict[str, FloatArray], mask: BoolArray, words: str) -> tuple[str, str]:
    """Return (caption with the mean, data address) of how two linear images differ."""
    reference, test = linear.values()
    found = difference_map(reference, test, mask)
    level = np.clip(np.nan_to_num(found) / MOST_DIFFERENT, 0.0, 1.0)
    steps = np.linspace(0.0, 1.0, len(_RAMP))
    colours = np.stack([np.interp(level, steps, column) for column in _RAMP.T], axis=-1)
    mean, largest = float(np.nanmean(found)), float(np.nanmax(found))
    caption = f"{words}: CIEDE2000 {number(mean)} on average, {number(largest)} at most"
    return caption, png_uri(cut_out(colours))


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
