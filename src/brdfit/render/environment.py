"""A panorama as light: what arrives from each direction, and directions drawn where it is bright.

An environment is an equirectangular picture of radiance. View coordinates are x right, y up, z
toward the viewer, and

    row 0         straight up, the last row straight down
    middle column what lies behind the sphere, where the camera looks (-z)
    columns to the right of it lie to the right (+x)

so that the panorama hangs behind the sphere as it is seen on a screen. `turned` moves its
middle to the right. Radiance is constant within a pixel of the picture, and so is the density
that directions are drawn with.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray, dot, frozen
from brdfit.errors import UsageError
from brdfit.tone import LUMINANCE

__all__ = ["Environment"]


@dataclass(frozen=True, eq=False)
class Environment:
    """Radiance from all around, frozen."""

    name: str
    radiance: FloatArray
    """(height, width, 3) linear sRGB, >= 0 and finite, any scale."""
    turned: float = 0.0
    """Radians by which the middle of the panorama stands to the right of -z."""

    def __post_init__(self) -> None:
        radiance = np.asarray(self.radiance, dtype=np.float64)
        if radiance.ndim != 3 or radiance.shape[2] != 3 or min(radiance.shape) < 2:
            raise UsageError(
                f"environment {self.name!r}: found an array of shape {radiance.shape} but a "
                f"panorama is (height, width, 3)."
            )
        if not (np.isfinite(radiance).all() and (radiance >= 0.0).all()):
            raise UsageError(
                f"environment {self.name!r}: holds values that are negative or not finite. "
                f"Clip them first."
            )
        if not radiance.any():
            raise UsageError(f"environment {self.name!r}: is black; nothing would be seen.")
        object.__setattr__(self, "radiance", frozen(radiance))

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) in pixels."""
        return self.radiance.shape[0], self.radiance.shape[1]

    def look(self, direction: FloatArray) -> FloatArray:
        """Return the radiance (n, 3) that arrives from `direction` (n, 3), unit vectors."""
        return np.asarray(self.radiance.reshape(-1, 3)[self._pixel(direction)])

    def density(self, direction: FloatArray) -> FloatArray:
        """Return how often `draw` gives `direction` (n, 3), per steradian, (n,)."""
        pixel = self._pixel(direction)
        return np.asarray(self._share[pixel] / self._solid_angle[pixel // self.shape[1]])

    def draw(self, u: FloatArray) -> FloatArray:
        """Return directions (n, 3) of points `u` (n, 2) in the unit square.

        A pixel is met as often as its luminance times its solid angle says; points that are
        even in the square are even in the light.
        """
        width = self.shape[1]
        rows, columns = self._cumulated
        row, down = _chosen(rows, u[:, 0])
        # all rows in one ascending list, row r from r to r + 1
        place, across = _chosen(
            columns, np.asarray(row + np.minimum(u[:, 1], 1.0 - 1e-12), dtype=np.float64)
        )
        column = place - row * width
        edges = self._edges
        y = edges[row] + down * (edges[row + 1] - edges[row])
        azimuth = ((column + across) / width - 0.5) * 2.0 * np.pi + self.turned
        ring = np.sqrt(np.maximum(1.0 - y * y, 0.0))
        return np.stack([ring * np.sin(azimuth), y, -ring * np.cos(azimuth)], axis=1)

    def _pixel(self, direction: FloatArray) -> IntArray:
        height, width = self.shape
        polar = np.arccos(np.clip(direction[:, 1], -1.0, 1.0))
        azimuth = np.arctan2(direction[:, 0], -direction[:, 2]) - self.turned
        row = np.minimum((polar / np.pi * height).astype(np.int64), height - 1)
        turn = np.mod(azimuth / (2.0 * np.pi) + 0.5, 1.0)
        return np.asarray(row * width + np.minimum((turn * width).astype(np.int64), width - 1))

    @cached_property
    def _edges(self) -> FloatArray:
        # y between rows, from 1 down to -1
        return np.cos(np.arange(self.shape[0] + 1) / self.shape[0] * np.pi)

    @cached_property
    def _solid_angle(self) -> FloatArray:
        # (height,) of one pixel in each row
        return -np.diff(self._edges) * (2.0 * np.pi / self.shape[1])

    @cached_property
    def _share(self) -> FloatArray:
        # (height * width,) summing to 1
        power = dot(self.radiance, np.asarray(LUMINANCE)) * self._solid_angle[:, None]
        return np.asarray(power.ravel() / power.sum())

    @cached_property
    def _cumulated(self) -> tuple[FloatArray, FloatArray]:
        # (rows, all columns): sums from 0; in `columns` row r runs from r to r + 1
        height, width = self.shape
        share = self._share.reshape(height, width)
        per_row = share.sum(axis=1)
        rows = np.concatenate([[0.0], np.cumsum(per_row)])
        within = share / np.where(per_row > 0.0, per_row, 1.0)[:, None]
        columns = np.cumsum(within, axis=1) + np.arange(height)[:, None]
        # a row that is dark is never chosen; rounding must not lead beyond the last pixel
        columns[:, -1] = np.arange(height) + 1.0
        return rows / rows[-1], np.concatenate([[0.0], columns.ravel()])


def _chosen(cumulated: FloatArray, u: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return (interval, place within it in [0, 1]) of `u` in ascending sums that start at 0."""
    index = np.searchsorted(cumulated, u, side="right") - 1
    index = np.clip(index, 0, cumulated.size - 2)
    low, high = cumulated[index], cumulated[index + 1]
    return index, np.clip((u - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0)
