"""The material ball: a sphere with a groove on a rounded foot, seen from a little above.

A surface of revolution about y in orthographic projection; what `brdfit.viewer` shows under
the same name. There are no shadows and no light between surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, frozen, normalize
from brdfit.render.illumination import rotation
from brdfit.render.sphere import Sphere

__all__ = ["MaterialBall"]

_CENTRE, _RADIUS, _GROOVE = 0.24, 0.74, 0.055
# A face that is seen from its edge is turned this much to the viewer: the pixel is lit.
_LEAST = 1e-4


@dataclass(frozen=True)
class MaterialBall(Sphere):
    """The geometry of a picture of `size` x `size` pixels; shaded as a `Sphere` is."""

    tilt: float = 0.22
    """Radians by which its top is turned to the viewer."""

    @property
    def mask(self) -> BoolArray:
        """(size, size) True where the ball is seen."""
        return self._seen[0]

    @property
    def normal(self) -> FloatArray:
        """(pixels, 3) unit normals of the pixels that see the ball, row by row."""
        return self._seen[1]

    @cached_property
    def _seen(self) -> tuple[BoolArray, FloatArray]:
        place, facing = self._surface()
        column = np.floor((place[:, 0] + 1.0) * self.size / 2.0).astype(np.int64)
        row = np.floor((1.0 - place[:, 1]) * self.size / 2.0).astype(np.int64)
        inside = (column >= 0) & (column < self.size) & (row >= 0) & (row < self.size)
        pixel, place, facing = (row * self.size + column)[inside], place[inside], facing[inside]
        # the nearest point of every pixel: last of those with its number
        order = np.lexsort((place[:, 2], pixel))
        last = np.flatnonzero(np.diff(pixel[order], append=-1))
        mask = np.zeros(self.size * self.size, dtype=bool)
        mask[pixel[order][last]] = True
        normal = facing[order][last]
        normal[:, 2] = np.maximum(normal[:, 2], _LEAST)
        return frozen(mask.reshape(self.size, self.size)), frozen(normalize(normal))

    def _surface(self) -> tuple[FloatArray, FloatArray]:
        """Return (points, normals) (n, 3), at least two a pixel along each way."""
        angle = np.linspace(0.0, 2.0 * np.pi, 4 * self.size, endpoint=False)
        around = np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)], axis=1)
        up = np.array([0.0, 1.0, 0.0])
        parts: list[tuple[FloatArray, FloatArray]] = []
        for radius, height, slope_r, slope_y in _outline(self.size):
            place = radius[:, None, None] * around + height[:, None, None] * up
            facing = slope_r[:, None, None] * around + slope_y[:, None, None] * up
            parts.append((place.reshape(-1, 3), facing.reshape(-1, 3)))
        turn = rotation(0.0, self.tilt).T
        return tuple(np.concatenate(one) @ turn for one in zip(*parts, strict=True))  # type: ignore[return-value]


def _outline(steps: int) -> list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]]:
    """Return the parts from top to bottom: radius, height, and the normal's two components."""
    return [
        _arc(0.0, 96.0, _RADIUS, (0.0, _CENTRE), 2 * steps),
        _arc(97.0, 107.0, _RADIUS - _GROOVE, (0.0, _CENTRE), steps),
        _arc(108.0, 152.0, _RADIUS, (0.0, _CENTRE), steps),
        _line((0.0, -0.5), (0.46, -0.5), steps),
        _arc(0.0, 90.0, 0.09, (0.46, -0.59), steps),
        _line((0.55, -0.59), (0.58, -0.86), steps),
    ]


def _arc(
    start: float, end: float, radius: float, centre: tuple[float, float], steps: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    angle = np.radians(np.linspace(start, end, steps))
    sine, cosine = np.sin(angle), np.cos(angle)
    return centre[0] + radius * sine, centre[1] + radius * cosine, sine, cosine


def _line(
    start: tuple[float, float], end: tuple[float, float], steps: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    share = np.linspace(0.0, 1.0, steps)
    across, along = end[0] - start[0], end[1] - start[1]
    length = float(np.hypot(across, along))
    return (
        start[0] + share * across,
        start[1] + share * along,
        np.full(steps, -along / length),
        np.full(steps, across / length),
    )
