"""Where samples scatter alike: near the mirror direction or not, near grazing or not.

Hat functions, each 1 at a node and 0 at its neighbours, of theta_h and of the larger of the
two polar angles. A BRDF changes faster than samples tell in its peak and toward grazing, and
instruments err at grazing and at normal incidence. Reciprocal, and blind to phi.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import half_diff_from_directions

__all__ = ["places"]

_THETA_H = np.array([0.0, 3.0, 7.0, 15.0, 30.0, 50.0, 80.0])
_LARGER_THETA = np.array([0.0, 25.0, 40.0, 60.0, 75.0, 82.0, 88.0])


def places(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return the hat functions (n, 14) at direction pairs (n, 3)."""
    theta_h = np.degrees(half_diff_from_directions(wi, wo)[0])
    lower = np.minimum(wi[:, 2], wo[:, 2])
    larger = np.degrees(np.arccos(np.clip(lower, -1.0, 1.0)))
    return np.hstack([_hats(theta_h, _THETA_H), _hats(larger, _LARGER_THETA)])


def _hats(degrees: FloatArray, nodes: FloatArray) -> FloatArray:
    return np.stack([np.interp(degrees, nodes, one) for one in np.eye(len(nodes))], axis=1)
