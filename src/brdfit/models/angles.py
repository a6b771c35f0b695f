"""The per-direction quantities that analytic BRDFs share, each computed once.

A kernel that evaluates hundreds of materials at the same directions takes a `PairAngles`,
so that half vectors, cosines and tangents are not worked out again for each material.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, as_directions, dot, normalize

__all__ = ["COS_FLOOR", "PairAngles"]

COS_FLOOR = float(np.cos(np.radians(89.5)))
"""Smallest cos(theta_i) and cos(theta_o) that a model divides by.

The denominators of microfacet models make f_r grow without bound at grazing. The MERL
tables have a resolution of one degree there, so nothing was fitted beyond the middle of
the last degree: nearer to the horizon a model keeps the cosine it has at 89.5 degrees.
"""

# Keeps tan^2(theta_h) finite for two directions along the horizon.
_COS_H_FLOOR = 1e-6


@dataclass(frozen=True, eq=False)
class PairAngles:
    """Quantities of n direction pairs; columns (n, 1) that broadcast over materials.

    | name               | unit and range                                       |
    |--------------------|------------------------------------------------------|
    | `cos_i`, `cos_o`   | cosines to the normal, at least `COS_FLOOR`          |
    | `theta_i`, `theta_o` | radians, [0, pi/2] above the horizon               |
    | `cos_h`            | cosine of theta_h, (0, 1]                            |
    | `versine_h`        | 1 - cos(theta_h), exact near 0                       |
    | `tan2_h`           | tan^2(theta_h)                                       |
    | `cos_d`            | cosine of theta_d = wi . wh, [0, 1]                  |
    | `above`            | both directions are above the horizon                |
    """

    cos_i: FloatArray
    cos_o: FloatArray
    theta_i: FloatArray
    theta_o: FloatArray
    cos_h: FloatArray
    versine_h: FloatArray
    tan2_h: FloatArray
    cos_d: FloatArray
    above: BoolArray

    @classmethod
    def of(cls, wi: FloatArray, wo: FloatArray) -> PairAngles:
        """Return the quantities of direction pairs, unit vectors (n, 3)."""
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        wh = normalize(wi + wo)
        sin2_h = wh[:, 0] ** 2 + wh[:, 1] ** 2
        cos_h = np.maximum(wh[:, 2], _COS_H_FLOOR)

        def column(values: FloatArray) -> FloatArray:
            return np.asarray(values[:, None])

        return cls(
            cos_i=column(np.maximum(wi[:, 2], COS_FLOOR)),
            cos_o=column(np.maximum(wo[:, 2], COS_FLOOR)),
            theta_i=column(np.arctan2(np.hypot(wi[:, 0], wi[:, 1]), wi[:, 2])),
            theta_o=column(np.arctan2(np.hypot(wo[:, 0], wo[:, 1]), wo[:, 2])),
            cos_h=column(cos_h),
            versine_h=column(sin2_h / (1.0 + cos_h)),
            tan2_h=column(sin2_h / cos_h**2),
            cos_d=column(np.clip(dot(wi, wh), 0.0, 1.0)),
            above=((wi[:, 2] > 0.0) & (wo[:, 2] > 0.0))[:, None],
        )
