"""Illuminations described by numbers: distant lights with their irradiance.

View coordinates: x to the right, y up, z toward the viewer. A light is a direction and
the irradiance that it gives a surface facing it, in linear sRGB; the scale is arbitrary,
since pictures are exposed before they are looked at.

    studio        40 directions; the one that defines the perceptual error
    point         one white light, above and left of the camera
    area_studio   three rectangular area lights and a dim even surround, for pictures
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.arrays import FloatArray, frozen, normalize
from brdfit.errors import UsageError

__all__ = [
    "ILLUMINATIONS",
    "Illumination",
    "Rectangle",
    "area_studio",
    "point",
    "rotation",
    "studio",
]

_GOLDEN_ANGLE = 2.399963
_STUDIO_LIGHTS = 40
_STUDIO_KEYS = (0, 18, 24, 29, 31)


@dataclass(frozen=True, eq=False)
class Illumination:
    """Distant lights and an even surround, frozen.

    | name         | shape  | unit and range                                             |
    |--------------|--------|------------------------------------------------------------|
    | `direction`  | (n, 3) | unit vectors toward the light, view coordinates            |
    | `irradiance` | (n, 3) | linear sRGB on a surface that faces the light, >= 0        |
    | `surround`   | 3      | linear sRGB radiance from everywhere, >= 0                 |
    """

    name: str
    direction: FloatArray
    irradiance: FloatArray
    surround: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        direction = np.asarray(self.direction, dtype=np.float64)
        irradiance = np.asarray(self.irradiance, dtype=np.float64)
        if direction.ndim != 2 or direction.shape[1] != 3 or irradiance.shape != direction.shape:
            raise UsageError(
                f"illumination {self.name!r}: found directions of shape {direction.shape} and "
                f"irradiances of shape {irradiance.shape} but both must be (lights, 3)."
            )
        object.__setattr__(self, "direction", frozen(normalize(direction)))
        object.__setattr__(self, "irradiance", frozen(irradiance))

    def __len__(self) -> int:
        return len(self.direction)

    def turned(self, yaw: float, pitch: float = 0.0) -> Illumination:
        """Return the lights turned about the vertical, then toward the viewer, radians."""
        return replace(self, direction=self.direction @ rotation(yaw, pitch).T)


def rotation(yaw: float, pitch: float) -> FloatArray:
    """Return the matrix (3, 3) that turns by `yaw` about y, then by `pitch` about x, radians."""
    (cy, sy), (cp, sp) = ((np.cos(angle), np.sin(angle)) for angle in (yaw, pitch))
    return np.array([[cy, 0.0, sy], [sp * sy, cp, -sp * cy], [-cp * sy, sp, cp * cy]])


def studio() -> Illumination:
    """Return the 40 directional lights under which the perceptual error is defined.

    For k = 0..39: y = 1 - 2 (k + 0.5) / 40, azimuth 2.399963 k, direction
    (sqrt(1 - y^2) cos, y, sqrt(1 - y^2) sin). Irradiance 0.15 (1 + 0.5 y) in all channels,
    and (1.5, 1.4, 1.2) more for k in {0, 18, 24, 29, 31}.
    """
    k = np.arange(_STUDIO_LIGHTS)
    y = 1.0 - 2.0 * (k + 0.5) / _STUDIO_LIGHTS
    ring, azimuth = np.sqrt(1.0 - y * y), _GOLDEN_ANGLE * k
    direction = np.stack([ring * np.cos(azimuth), y, ring * np.sin(azimuth)], axis=1)
    irradiance = np.repeat(0.15 * (1.0 + 0.5 * y)[:, None], 3, axis=1)
    irradiance[np.isin(k, _STUDIO_KEYS)] += (1.5, 1.4, 1.2)
    return Illumination("studio", direction, irradiance)


def point(elevation: float = 30.0) -> Illumination:
    """Return one white light `elevation` degrees off the camera axis, up and to the left."""
    angle = np.deg2rad(elevation)
    aside = np.sin(angle) / np.sqrt(2.0)
    return Illumination("point", np.array([[-aside, aside, np.cos(angle)]]), np.ones((1, 3)))


@dataclass(frozen=True)
class Rectangle:
    """A rectangular light at a distance, facing the sphere's centre.

    The sphere is small beside the distance: every point of it sees the light in the same
    directions.
    """

    toward: tuple[float, float, float]
    """Direction of the middle, view coordinates; need not be a unit vector."""
    width: float
    """Horizontal extent over distance."""
    height: float
    """Vertical extent over distance."""
    radiance: tuple[float, float, float]
    """Linear sRGB."""

    def lights(self, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Return (direction, irradiance) of the midpoint rule, `spacing` in radians or finer."""
        middle = normalize(np.asarray(self.toward, dtype=np.float64))
        right = normalize(np.cross([0.0, 1.0, 0.0], middle))
        up = np.cross(middle, right)
        u, v = np.meshgrid(_midpoints(self.width, spacing), _midpoints(self.height, spacing))
        at = middle + u.reshape(-1, 1) * right + v.reshape(-1, 1) * up
        # d(omega) = dA cos / r^2, and cos = 1 / r for a plane at distance 1
        solid_angle = (self.width * self.height / u.size) / np.linalg.norm(at, axis=1) ** 3
        return normalize(at), solid_angle[:, None] * np.asarray(self.radiance)


# Key light above left, a narrow strip on the right, a weak one from below.
_KEY = Rectangle((-0.8, 0.9, 0.9), 0.7, 0.7, (6.0, 5.8, 5.4))
_STRIP = Rectangle((1.0, 0.25, 0.55), 0.25, 1.2, (4.5, 4.8, 5.4))
_FILL = Rectangle((0.1, -1.0, 0.5), 0.9, 0.25, (1.5, 1.5, 1.5))
_SURROUND = (0.12, 0.12, 0.12)


def area_studio(spacing: float = 0.085) -> Illumination:
    """Return three rectangular area lights and a dim even surround.

    `spacing`, in radians, is the distance between the points that stand for an area: a
    lobe narrower than that shows them one by one.
    """
    lights = [rectangle.lights(spacing) for rectangle in (_KEY, _STRIP, _FILL)]
    direction, irradiance = (np.concatenate(parts) for parts in zip(*lights, strict=True))
    return Illumination("area_studio", direction, irradiance, _SURROUND)


ILLUMINATIONS = {"studio": studio, "point": point, "area_studio": area_studio}
"""Built-in illuminations: name -> function without required arguments."""


def _midpoints(extent: float, spacing: float) -> FloatArray:
    n = max(1, int(np.ceil(extent / spacing)))
    return np.asarray(((np.arange(n) + 0.5) / n - 0.5) * extent)
