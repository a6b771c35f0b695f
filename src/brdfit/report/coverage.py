"""Where the samples of a file lie, and how much of the domain is near one of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import spherical_from_directions, wrap_phi_d
from brdfit.grid import Grid
from brdfit.samples import Samples

__all__ = ["FAR", "NEAR", "Coverage", "Reach", "coverage_of"]

NEAR = 5.0
"""Degrees in half/difference coordinates within which a sample speaks for a direction."""

FAR = 15.0
"""Degrees beyond which a direction is no longer interpolated, but supplied by the method."""

_NODES = Grid(30, 30, 36)


@dataclass(frozen=True)
class Coverage:
    """Ranges of the usable samples, in degrees, and the share of the domain near one."""

    theta_i: tuple[float, float]
    """Smallest and largest polar angle of the light."""
    theta_o: tuple[float, float]
    """Smallest and largest polar angle of the detector."""
    theta_h: tuple[float, float]
    """Smallest and largest half angle: 0 is the specular peak."""
    theta_d: tuple[float, float]
    """Smallest and largest difference angle: 90 is grazing."""
    share: float
    """Share of the domain, by how often random pairs of directions fall there, in [0, 1]."""
    share_between: float
    """Share of the domain that is not near, but within `far`: interpolated."""
    near: float = NEAR
    """Degrees that count as near."""
    far: float = FAR
    """Degrees beyond which the method, not a measurement, supplies the value."""

    def record(self) -> dict[str, Any]:
        """Return the figures as JSON-able values."""
        return asdict(self)

    def __str__(self) -> str:
        """Return one line for a person."""
        ranges = ", ".join(
            f"{name} {low:.0f}-{high:.0f}"
            for name, (low, high) in (
                ("theta_i", self.theta_i),
                ("theta_o", self.theta_o),
                ("theta_h", self.theta_h),
                ("theta_d", self.theta_d),
            )
        )
        return f"{ranges} degrees; {self.share:.0%} of the domain within {self.near:g} degrees"


class Reach:
    """How far any direction is from the nearest usable sample.

    Distance is Euclidean in (theta_h, theta_d) and the arc that phi_d spans there, with
    phi_d taken by reciprocity. Without a usable sample every distance is infinite.
    """

    def __init__(self, samples: Samples) -> None:
        from scipy.spatial import cKDTree

        used = samples.usable.any(axis=1)
        points = _embedded(*(angle[used] for angle in samples.half_diff))
        # Twenty thousand points already fill what hundreds of thousands fill.
        step = max(1, len(points) // 20_000)
        self._tree = cKDTree(points[::step])

    def degrees(
        self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray, most: float = FAR
    ) -> FloatArray:
        """Return the distance, shaped as the angles (radians); infinite beyond `most`."""
        angles = np.broadcast_arrays(theta_h, theta_d, phi_d)
        distance, _ = self._tree.query(
            _embedded(*angles), distance_upper_bound=np.radians(most) * (1.0 + 1e-12)
        )
        return np.asarray(np.degrees(distance))


def coverage_of(samples: Samples) -> Coverage | None:
    """Return the coverage of the usable samples; None if there are none.

    The shares are over a grid of 30 x 30 x 36 nodes; the distance is that of `Reach`.
    """
    used = samples.usable.any(axis=1)
    if not used.any():
        return None
    theta_i, _ = spherical_from_directions(samples.wi[used])
    theta_o, _ = spherical_from_directions(samples.wo[used])
    theta_h, theta_d, _ = (angle[used] for angle in samples.half_diff)
    distance = Reach(samples).degrees(*_NODES.half_diff(_NODES.cells))
    measure = _NODES.solid_angle.reshape(-1)[_NODES.cells]
    near, between = distance <= NEAR, (distance > NEAR) & (distance <= FAR)
    return Coverage(
        theta_i=_range(theta_i),
        theta_o=_range(theta_o),
        theta_h=_range(theta_h),
        theta_d=_range(theta_d),
        share=float(measure[near].sum() / measure.sum()),
        share_between=float(measure[between].sum() / measure.sum()),
    )


def _range(angle: FloatArray) -> tuple[float, float]:
    return float(np.degrees(angle.min())), float(np.degrees(angle.max()))


def _embedded(theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> FloatArray:
    """Points (n, 4) whose distances are angles in radians; phi_d has period pi.

    Turning phi_d by d moves the directions by about min(sin theta_h, sin theta_d) d, and not
    at all at either pole.
    """
    phi = wrap_phi_d(phi_d)
    radius = 0.5 * np.minimum(np.sin(theta_h), np.sin(theta_d))
    return np.stack([theta_h, theta_d, radius * np.cos(2 * phi), radius * np.sin(2 * phi)], axis=-1)
