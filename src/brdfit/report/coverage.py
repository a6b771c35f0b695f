"""Where the samples of a file lie, and how much of the domain is near one of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import spherical_from_directions
from brdfit.grid import Grid
from brdfit.reconstruct.reach import FAR, NEAR, Reach
from brdfit.samples import Samples

__all__ = ["FAR", "NEAR", "Coverage", "Reach", "coverage_of"]

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
