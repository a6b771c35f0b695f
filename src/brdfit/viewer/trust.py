"""The trust map: which part of a result was measured, interpolated, or supplied."""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import Grid
from brdfit.report.coverage import FAR, NEAR, Reach
from brdfit.viewer.item import Item
from brdfit.viewer.messages import TrustPlane

__all__ = ["trust_message"]

_NODES = Grid(60, 60, 36)
_NAMES = ("measured", "interpolated", "supplied by the population")


def trust_message(item: Item, phi_d: float) -> TrustPlane:
    """Return the map at `phi_d`, degrees; `UsageError` where no samples are known."""
    reach = item.reach
    if reach is None:
        raise UsageError(f"{item.name}: no samples are known; where it comes from cannot be told.")
    # The middle of each cell of the map: its edges are the nodes.
    theta_h = (np.arange(_NODES.n_theta_h) + 0.5) ** 2 / _NODES.n_theta_h**2 * (np.pi / 2)
    theta_d = (np.arange(_NODES.n_theta_d) + 0.5) / _NODES.n_theta_d * (np.pi / 2)
    mesh_d, mesh_h = np.meshgrid(theta_d, theta_h, indexing="ij")
    plane = np.full(mesh_h.shape, np.radians(phi_d))
    cos_i, cos_o = cos_incident_outgoing(mesh_h, mesh_d, plane)
    code = np.where((cos_i > 0.0) & (cos_o > 0.0), _code(reach.degrees(mesh_h, mesh_d, plane)), 0)
    return TrustPlane(
        phi_d=phi_d,
        theta_h=np.degrees(theta_h).tolist(),
        theta_d=np.degrees(theta_d).tolist(),
        code=code.tolist(),
        names=list(_NAMES),
        shares=_shares(reach),
        definition=(
            f"measured: a usable sample within {NEAR:g} degrees; interpolated: within {FAR:g} "
            f"degrees; beyond that the population speaks."
        ),
    )


def _code(degrees: FloatArray) -> IntArray:
    return np.where(degrees <= NEAR, 1, np.where(degrees <= FAR, 2, 3))


def _shares(reach: Reach) -> list[float]:
    code = _code(reach.degrees(*_NODES.half_diff(_NODES.cells)))
    measure = _NODES.solid_angle.reshape(-1)[_NODES.cells]
    return [float(measure[code == index + 1].sum() / measure.sum()) for index in range(3)]
