"""What a GGX lobe reflects in all, as a sum of two parts that need no Fresnel term.

With Schlick's F = f0 (1 - s) + f90 s, s = (1 - wi . wh)^5, the directional albedo of a lobe is
f0 A(theta_o, alpha) + f90 B(theta_o, alpha). A and B are integrated once, on a grid.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.models import Ggx

__all__ = ["albedo_split"]

_COSINES = np.linspace(0.0, 1.0, 33) ** 1.5
_ROUGHNESS = np.linspace(0.03, 1.0, 40)
_GRAZING = 0.01


def albedo_split(cosine: FloatArray, alpha: float) -> tuple[FloatArray, FloatArray]:
    """Return (A, B), shaped as `cosine` (of the detector), of one roughness `alpha`."""
    root = float(np.clip(np.sqrt(alpha), _ROUGHNESS[0], _ROUGHNESS[-1]))
    at = np.interp(root, _ROUGHNESS, np.arange(_ROUGHNESS.size))
    low = min(int(at), _ROUGHNESS.size - 2)
    share = at - low
    columns = [(1.0 - share) * table[:, low] + share * table[:, low + 1] for table in _tables()]
    a, b = (np.interp(cosine, _COSINES, column) for column in columns)
    return a, b


@cache
def _tables() -> tuple[FloatArray, FloatArray]:
    """(cosines, roughnesses) each: A and B."""
    theta = np.arccos(np.clip(_COSINES, _GRAZING, 1.0))
    lobes = {f0: Ggx(diffuse=0.0, f0=f0, alpha=_ROUGHNESS**2) for f0 in (0.0, 1.0)}
    # f0 = 1 reflects A + B, f0 = 0 reflects B
    both, b = (np.minimum(directional_albedo(lobes[f0], theta), 1.0) for f0 in (1.0, 0.0))
    return np.maximum(both - b, 0.0), b
