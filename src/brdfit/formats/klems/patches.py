"""The angle bases: bands of the polar angle, each cut into equal patches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_spherical

__all__ = ["BASES", "FULL", "Basis"]


@dataclass(frozen=True)
class Basis:
    """Bands from the normal to the horizon; patch 0 is the cap about the normal."""

    name: str
    bounds: tuple[float, ...]
    """Lower polar angle of each band, then 90; degrees."""
    counts: tuple[int, ...]
    """Patches of each band; the first is centred at azimuth 0."""

    @property
    def size(self) -> int:
        """Number of patches."""
        return sum(self.counts)

    def points(self, polar: FloatArray, azimuth: FloatArray) -> FloatArray:
        """Return directions (size, len(polar), 3) within every patch.

        `polar` in [0, 1] is the place between the bounds by projected solid angle (0.5 in
        the middle by that measure), `azimuth` in [-0.5, 0.5] in widths of the patch.
        """
        low, high, phi, width = [], [], [], []
        for band, count in enumerate(self.counts):
            low += [self.bounds[band]] * count
            high += [self.bounds[band + 1]] * count
            phi += [360.0 * k / count for k in range(count)]
            width += [360.0 / count] * count
        sin2_low, sin2_high = np.sin(np.deg2rad(low)) ** 2, np.sin(np.deg2rad(high)) ** 2
        sin2 = sin2_low[:, None] + (sin2_high - sin2_low)[:, None] * polar
        angle = np.array(phi)[:, None] + np.array(width)[:, None] * azimuth
        return directions_from_spherical(np.arcsin(np.sqrt(sin2)), np.deg2rad(angle))

    def middles(self) -> FloatArray:
        """Return the middle (size, 3) of each patch; of the cap that is the normal."""
        middle = self.points(np.array([0.5]), np.array([0.0]))[:, 0]
        middle[0] = [0.0, 0.0, 1.0]
        return middle


FULL = Basis(
    "LBNL/Klems Full",
    (0.0, 5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 90.0),
    (1, 8, 16, 20, 24, 24, 24, 16, 12),
)
"""145 patches."""

BASES = {
    basis.name.lower(): basis
    for basis in (
        FULL,
        Basis(
            "LBNL/Klems Half",
            (0.0, 6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90.0),
            (1, 8, 12, 16, 20, 12, 4),
        ),
        Basis("LBNL/Klems Quarter", (0.0, 9.0, 27.0, 46.0, 66.0, 90.0), (1, 8, 12, 12, 8)),
    )
}
"""By name in lower case."""
