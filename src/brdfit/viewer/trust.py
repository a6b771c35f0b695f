"""The trust map: which part of a result was measured, interpolated, or supplied.

A fit is asked itself (`Reconstruction.trust_map`: distance to what it believes, and how sure it
is), one that was opened from disk by what its record keeps. Without such a record distance to
the samples decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.geometry import cos_incident_outgoing, directions_from_half_diff
from brdfit.grid import Grid
from brdfit.reconstruct.reach import FAR, NEAR
from brdfit.reconstruct.trust import TrustMap
from brdfit.viewer.item import Item
from brdfit.viewer.messages import TrustPlane

__all__ = ["trust_message"]

_NODES = Grid(60, 60, 36)
# For the shares: a method that knows how sure it is takes a second for ten thousand directions.
_COARSE = Grid(30, 30, 18)
_NAMES = ("measured", "interpolated", "supplied by the population")


def trust_message(item: Item, phi_d: float) -> TrustPlane:
    """Return the map at `phi_d`, degrees; `UsageError` where no samples are known."""
    judge = _Judge.of(item)
    # The middle of each cell of the map: its edges are the nodes.
    theta_h = (np.arange(_NODES.n_theta_h) + 0.5) ** 2 / _NODES.n_theta_h**2 * (np.pi / 2)
    theta_d = (np.arange(_NODES.n_theta_d) + 0.5) / _NODES.n_theta_d * (np.pi / 2)
    mesh_d, mesh_h = np.meshgrid(theta_d, theta_h, indexing="ij")
    plane = np.full(mesh_h.shape, np.radians(phi_d))
    cos_i, cos_o = cos_incident_outgoing(mesh_h, mesh_d, plane)
    above = (cos_i > 0.0) & (cos_o > 0.0)
    code: IntArray = np.zeros(above.shape, dtype=np.int64)
    code[above] = judge.codes(mesh_h[above], mesh_d[above], plane[above])
    return TrustPlane(
        phi_d=phi_d,
        theta_h=np.degrees(theta_h).tolist(),
        theta_d=np.degrees(theta_d).tolist(),
        code=code.tolist(),
        names=list(_NAMES),
        shares=item.once("trust shares", lambda: _shares(judge)),
        definition=judge.definition,
    )


@dataclass(frozen=True, eq=False)
class _Judge:
    """Codes 1 to 3 of directions above the horizon, and what they mean."""

    codes: Callable[[FloatArray, FloatArray, FloatArray], IntArray]
    definition: str

    @classmethod
    def of(cls, item: Item) -> _Judge:
        """Return the judge of an item; `UsageError` where no samples are known."""
        own = _own(item)
        if own is not None:
            return cls(
                lambda *angles: own.evaluate(*directions_from_half_diff(*angles)), own.definition
            )
        reach = item.reach
        if reach is None:
            raise UsageError(
                f"{item.name}: no samples are known; where it comes from cannot be told."
            )
        return cls(
            lambda *angles: _by_distance(reach.degrees(*angles)),
            f"measured: a usable sample within {NEAR:g} degrees; interpolated: within {FAR:g} "
            f"degrees; beyond that the population speaks.",
        )


def _own(item: Item) -> TrustMap | None:
    if item.result is not None:
        return item.result.trust_map
    return None if item.fitted.trust is None else item.fitted.trust.map


def _by_distance(degrees: FloatArray) -> IntArray:
    return np.where(degrees <= NEAR, 1, np.where(degrees <= FAR, 2, 3))


def _shares(judge: _Judge) -> list[float]:
    code = judge.codes(*_COARSE.half_diff(_COARSE.cells))
    measure = _COARSE.solid_angle.reshape(-1)[_COARSE.cells]
    return [float(measure[code == index + 1].sum() / measure.sum()) for index in range(3)]
