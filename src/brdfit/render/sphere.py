"""A sphere seen along +z: which directions each pixel asks a BRDF for, and the shaded image.

The unit sphere in orthographic projection, view coordinates x right, y up, z toward the
viewer; row 0 is the top. A pixel whose middle lies on the disk sees the normal
n = (x, y, sqrt(1 - x^2 - y^2)) and, for lights of direction l and irradiance E,

    L = sum_l f_r(wi, wo) E max(n . l, 0)

with wi and wo in the frame of n. The BRDF is isotropic, so any frame about n serves. An
even surround of radiance S adds S times the directional albedo at the pixel's theta_o.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from brdfit.albedo import Evaluable, directional_albedo
from brdfit.arrays import BoolArray, FloatArray, IntArray, dot, frozen
from brdfit.errors import UsageError
from brdfit.progress import Progress, silent
from brdfit.render.illumination import Illumination
from brdfit.tone import LUMINANCE

__all__ = ["Queries", "Sphere", "in_channels", "sum_by"]

# Pairs at a time: enough to amortise a call, few enough to stay in cache.
_CHUNK = 40_000
# A light this close to a pixel's horizon gives it nothing; the BRDF there may be anything.
_HORIZON = 1e-6
_ALBEDO_ANGLES = 40


class Queries(NamedTuple):
    """What a sphere under an illumination asks of a BRDF: one row a pixel and light.

    | name     | shape  | meaning                                                   |
    |----------|--------|-----------------------------------------------------------|
    | `wi`     | (n, 3) | toward the light, in the pixel's frame, above its horizon |
    | `wo`     | (n, 3) | toward the viewer, in the pixel's frame                   |
    | `pixel`  | (n,)   | which pixel of the disk, row by row, ascending            |
    | `light`  | (n,)   | which light of the illumination                           |
    | `cosine` | (n,)   | n . l, the share of the irradiance that arrives           |
    """

    wi: FloatArray
    wo: FloatArray
    pixel: IntArray
    light: IntArray
    cosine: FloatArray


@dataclass(frozen=True)
class Sphere:
    """The geometry of a sphere image of `size` x `size` pixels."""

    size: int = 64

    def __post_init__(self) -> None:
        if self.size < 2:
            raise UsageError(f"Sphere: size is {self.size} but an image needs at least 2 pixels.")

    @cached_property
    def _plane(self) -> tuple[FloatArray, FloatArray]:
        middle = (2.0 * np.arange(self.size) + 1.0) / self.size - 1.0
        x, y = np.meshgrid(middle, -middle)
        return x, y

    @cached_property
    def mask(self) -> BoolArray:
        """(size, size) True on the disk."""
        x, y = self._plane
        return frozen(x * x + y * y < 1.0)

    @cached_property
    def normal(self) -> FloatArray:
        """(pixels, 3) unit normals of the pixels of the disk, row by row."""
        x, y = (axis[self.mask] for axis in self._plane)
        return frozen(np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], axis=1))

    @cached_property
    def frame(self) -> FloatArray:
        """(pixels, 3, 3) rows tangent, bitangent, normal of each pixel of the disk."""
        # The tangent is the view direction laid into the surface, or +x in the one pixel that
        # may face the viewer.
        n = self.normal
        sine = np.hypot(n[:, 0], n[:, 1])
        facing = sine < 1e-9
        tangent = np.stack([-n[:, 0] * n[:, 2], -n[:, 1] * n[:, 2], sine * sine], axis=1)
        tangent = tangent / np.where(facing, 1.0, sine)[:, None]
        tangent[facing] = (1.0, 0.0, 0.0)
        return np.stack([tangent, np.cross(n, tangent), n], axis=1)

    def directions(self, illumination: Illumination) -> Queries:
        """Return all that the sphere asks of a BRDF under the lights of `illumination`.

        The surround is not among them: it is no direction.
        """
        chunks = list(self._chunks(illumination, len(self.normal)))
        return chunks[0]

    def shade(
        self, brdf: Evaluable, illumination: Illumination, progress: Progress = silent
    ) -> FloatArray:
        """Return the linear image (size, size, channels), 0 beside the disk.

        Three channels are lit by the light's R, G and B; any other number by the light's
        luminance, so that monochrome data stay grey.
        """
        total = len(self.normal)
        per_chunk = max(1, _CHUNK // max(len(illumination), 1))
        disk: list[FloatArray] = []
        progress("shading", 0, total)
        for queries in self._chunks(illumination, per_chunk):
            value = brdf.evaluate(queries.wi, queries.wo)
            amount = in_channels(illumination.irradiance, value.shape[1])[queries.light]
            light = value * amount * queries.cosine[:, None]
            disk.append(sum_by(queries.pixel, light, per_chunk))
            progress("shading", min(len(disk) * per_chunk, total), total)
        shaded = np.concatenate(disk)[:total]
        if any(illumination.surround):
            surround = np.asarray(illumination.surround)[None, :]
            shaded += in_channels(surround, shaded.shape[1]) * self._albedo(brdf)
        return self.image(shaded)

    def _albedo(self, brdf: Evaluable) -> FloatArray:
        # It depends on theta_o alone: a few angles, then interpolation in cos theta_o.
        cosine = np.linspace(0.02, 1.0, _ALBEDO_ANGLES)
        albedo = directional_albedo(brdf, np.arccos(cosine), rings=64, spokes=8)
        columns = [np.interp(self.normal[:, 2], cosine, column) for column in albedo.T]
        return np.stack(columns, axis=1)

    def image(self, disk: FloatArray) -> FloatArray:
        """Return (size, size, channels) from values (pixels, channels) of the disk."""
        picture = np.zeros((self.size, self.size, disk.shape[1]))
        picture[self.mask] = disk
        return picture

    def _chunks(self, illumination: Illumination, pixels: int) -> Iterator[Queries]:
        for first in range(0, len(self.normal), pixels):
            frame = self.frame[first : first + pixels]
            # wi[p, l, :] = frame[p] @ direction[l]
            wi = np.einsum("pij,lj->pli", frame, illumination.direction)
            pixel, light = np.nonzero(wi[..., 2] > _HORIZON)
            wi = wi[pixel, light]
            wo = frame[:, :, 2][pixel]
            yield Queries(wi, wo, pixel, light, wi[:, 2])


def in_channels(light: FloatArray, channels: int) -> FloatArray:
    """Return light (n, 3), linear sRGB, as it lights values of that many channels."""
    if channels == 3:
        return light
    return np.repeat(dot(light, np.asarray(LUMINANCE))[:, None], channels, axis=1)


def sum_by(group: IntArray, value: FloatArray, n: int) -> FloatArray:
    """Return the sums (n, c) of the rows of value (m, c) that share a group in [0, n)."""
    columns = [np.bincount(group, weights=column, minlength=n) for column in value.T]
    return np.stack(columns, axis=1)
