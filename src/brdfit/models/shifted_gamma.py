"""The shifted-gamma microfacet BRDF, whose fits to the 100 MERL materials are published.

    f(wi, wo) = [rho_d + rho_s F(c) D(theta_h) G(theta_i) G(theta_o) / (cos_i cos_o)] / pi

    F(c)      = f0 - c f1 + (1 - c)^5 (1 - f0),                  c = wi . wh
    D(theta)  = kap exp(-x) / (pi x^p cos^4 theta),              x = alpha + tan^2(theta) / alpha
    G(theta)  = clamp(1 + lambda (1 - exp(c_g max(0, theta - theta0)^k)), 0, 1)

A column of parameters is one channel of one material. Some published columns have a
Fresnel term that dips below zero: it is held at zero, so that f >= rho_d / pi.

Reference: M. M. Bagher, C. Soler, N. Holzschuch, "Accurate fitting of measured reflectances
using a Shifted Gamma micro-facet distribution", Computer Graphics Forum 31(4), 2012.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.models.angles import PairAngles
from brdfit.models.columns import freeze_columns

__all__ = ["ShiftedGamma"]

# exp of it is nothing beside any diffuse term, and still a normal number.
_NOTHING = -200.0
_TINY = 1e-300


@dataclass(frozen=True, eq=False)
class ShiftedGamma:
    """Parameters (columns,), a column being a channel, or a channel of one of many materials."""

    rho_d: npt.ArrayLike
    """Diffuse albedo."""
    rho_s: npt.ArrayLike
    """Specular scale."""
    alpha: npt.ArrayLike
    """Width of the distribution, > 0."""
    p: npt.ArrayLike
    """Exponent of its tail."""
    f0: npt.ArrayLike
    """Fresnel term at normal incidence before the linear part."""
    f1: npt.ArrayLike
    """Slope of the Fresnel term in c."""
    kap: npt.ArrayLike
    """Normalisation of the distribution, > 0."""
    lambda_: npt.ArrayLike
    """Strength of the masking term."""
    c: npt.ArrayLike
    """Scale within the masking term, > 0."""
    k: npt.ArrayLike
    """Power within the masking term."""
    theta0: npt.ArrayLike
    """Angle at which masking begins, radians."""

    def __post_init__(self) -> None:
        freeze_columns(self)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, columns) in 1/sr at (n, 3); 0 below the horizon."""
        angles = PairAngles.of(wi, wo)
        return np.where(angles.above, self.at(angles), 0.0)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, columns), as if every direction were above the horizon."""
        specular = self._distribution(angles)
        specular *= self._masking(angles.theta_i)
        specular *= self._masking(angles.theta_o)
        specular *= self._fresnel(angles.cos_d)
        specular *= (1.0 / np.pi) / (angles.cos_i * angles.cos_o)
        specular += np.asarray(self.rho_d) / np.pi
        return specular

    def _fresnel(self, cos_d: FloatArray) -> FloatArray:
        # rho_s F, linear in (1, c, (1 - c)^5): one small product for all columns.
        rho_s, f0, f1 = (np.asarray(value) for value in (self.rho_s, self.f0, self.f1))
        powers = np.hstack([np.ones_like(cos_d), cos_d, (1.0 - cos_d) ** 5])
        fresnel = powers @ (rho_s * np.stack([f0, -f1, 1.0 - f0]))
        return np.asarray(np.maximum(fresnel, 0.0, out=fresnel))

    def _distribution(self, angles: PairAngles) -> FloatArray:
        # D in the logarithm: x^p and exp(-x) overflow or vanish separately, not together.
        alpha = np.asarray(self.alpha)
        x = angles.tan2_h * (1.0 / alpha)
        x += alpha
        exponent = np.log(x)
        exponent *= -np.asarray(self.p)
        exponent -= x
        exponent += np.log(np.asarray(self.kap) / np.pi)
        exponent -= 4.0 * np.log(angles.cos_h)
        np.maximum(exponent, _NOTHING, out=exponent)
        return np.asarray(np.exp(exponent, out=exponent))

    def _masking(self, theta: FloatArray) -> FloatArray:
        # c u^k = exp(k ln u + ln c), because c reaches 1e38 and k 856. The clip changes
        # nothing that a float can tell (lambda is between 4e-8 and 2e7): below it G = 1,
        # above it G = 0. It keeps the exponentials off their slow path for overflow.
        u = theta - np.asarray(self.theta0)
        np.maximum(u, _TINY, out=u)
        np.log(u, out=u)
        u *= np.asarray(self.k)
        u += np.log(np.asarray(self.c))
        np.clip(u, -40.0, 4.0, out=u)
        np.exp(u, out=u)
        np.expm1(u, out=u)
        u *= -np.asarray(self.lambda_)
        u += 1.0
        return np.asarray(np.clip(u, 0.0, 1.0, out=u))
