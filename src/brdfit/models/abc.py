"""The ABC microfacet BRDF, whose fits to the 100 MERL materials are published.

    f(wi, wo) = k_d / pi + F(theta_d) D(theta_h) G(wi, wo) / (pi cos_i cos_o)

    D = a / (1 + b (1 - cos theta_h))^c
    F = unpolarised Fresnel reflectance of a dielectric of that index of refraction
    G = min(1, 2 cos_h cos_o / cos_d, 2 cos_h cos_i / cos_d)      (Cook and Torrance 1982)

Reference: J. Low, J. Kronander, A. Ynnerman, J. Unger, "BRDF models for accurate and
efficient rendering of glossy surfaces", ACM Transactions on Graphics 31(1), 2012.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns
from brdfit.models.fresnel import dielectric

__all__ = ["Abc", "AbcLobe"]


@dataclass(frozen=True, eq=False)
class AbcLobe:
    """The part of the model that the channels of a material share: (columns,) parameters."""

    b: npt.ArrayLike
    """Inverse width of the lobe, > 0."""
    c: npt.ArrayLike
    """Fall-off of its tail, > 0."""
    ior: npt.ArrayLike
    """Index of refraction, >= 1."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return F D G / (a pi cos_i cos_o), (n, columns)."""
        cos_h, cos_d = angles.cos_h, np.maximum(angles.cos_d, 1e-9)
        near = np.minimum(angles.cos_i, angles.cos_o)
        groove = np.minimum(1.0, 2.0 * cos_h * near / cos_d)
        lobe = angles.versine_h * np.asarray(self.b)
        np.log1p(lobe, out=lobe)
        lobe *= -np.asarray(self.c)
        np.exp(lobe, out=lobe)
        lobe *= groove / (np.pi * angles.cos_i * angles.cos_o)
        lobe *= dielectric(angles.cos_d, np.asarray(self.ior))
        return np.asarray(lobe)


@dataclass(frozen=True, eq=False)
class Abc:
    """Parameters (columns,), a column being a channel, or a channel of one of many materials."""

    k_d: npt.ArrayLike
    """Diffuse albedo."""
    a: npt.ArrayLike
    """Height of the specular lobe."""
    b: npt.ArrayLike
    """Inverse width of the lobe, > 0."""
    c: npt.ArrayLike
    """Fall-off of its tail, > 0."""
    ior: npt.ArrayLike
    """Index of refraction, >= 1."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        value = AbcLobe(self.b, self.c, self.ior).at(angles)
        value *= np.asarray(self.a)
        value += np.asarray(self.k_d) / np.pi
        return np.where(angles.above, value, 0.0)
