"""Where the samples of a file lie, and how much of the domain is near one of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import spherical_from_directions, wrap_phi_d
from brdfit.grid import Grid
from brdfit.samples import Samples

__all__ = ["NEAR", "Coverage", "coverage_of"]

NEAR = 5.0
"""Degrees in half/difference coordinates within which a sample speaks for a direction."""

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
    near: float = NEAR
    """Degrees that count as near."""

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


def coverage_of(samples: Samples) -> Coverage | None:
    """Return the coverage of the usable samples; None if there are none.

    Distance is Euclidean in (theta_h, theta_d) and the arc that phi_d spans there, with
    phi_d taken by reciprocity, over a grid of 30 x 30 x 36 nodes.
    """
    used = samples.usable.any(axis=1)
    if not used.any():
        return None
    theta_i, _ = spherical_from_directions(samples.wi[used])
    theta_o, _ = spherical_from_directions(samples.wo[used])
    theta_h, theta_d, phi_d = (angle[used] for angle in samples.half_diff)
    return Coverage(
        theta_i=_range(theta_i),
        theta_o=_range(theta_o),
        theta_h=_range(theta_h),
        theta_d=_range(theta_d),
        share=_share_near(theta_h, theta_d, phi_d),
    )


def _range(angle: FloatArray) -> tuple[float, float]:
    return float(np.degrees(angle.min())), float(np.degrees(angle.max()))


def _share_near(theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> float:
    from scipy.spatial import cKDTree

    nodes = _NODES.half_diff(_NODES.cells)
    # Twenty thousand points already fill what hundreds of thousands fill.
    step = max(1, len(theta_h) // 20_000)
    tree = cKDTree(_embedded(theta_h, theta_d, phi_d)[::step])
    reach, _ = tree.query(_embedded(*nodes), distance_upper_bound=np.radians(NEAR))
    measure = _NODES.solid_angle.reshape(-1)[_NODES.cells]
    return float(measure[np.isfinite(reach)].sum() / measure.sum())


def _embedded(theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> FloatArray:
    """Points (n, 4) whose distances are angles in radians; phi_d has period pi.

    Turning phi_d by d moves the directions by about min(sin theta_h, sin theta_d) d, and not
    at all at either pole.
    """
    phi = wrap_phi_d(phi_d)
    radius = 0.5 * np.minimum(np.sin(theta_h), np.sin(theta_d))
    return np.stack([theta_h, theta_d, radius * np.cos(2 * phi), radius * np.sin(2 * phi)], axis=-1)
