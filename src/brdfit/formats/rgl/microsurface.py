"""The microsurface that stands behind a BRDF: normals, projected area, visible normals.

Where light and detector are in one place, w, a microfacet model says

    f_r(w, w) = F D(w) / (4 sigma(w) cos(theta)),   sigma(w) = int D(m) max(w . m, 0) dm

with a constant F. Written as D = (4 / F) cos(theta) f_r(w, w) sigma(w), and sigma being
linear in D, this says that D is the eigenvector of a positive operator, which iterating it
finds: backscatter alone tells the distribution of normals. D is scaled so that the normals'
areas, projected on the surface, add up to 1; then sigma is 1 at the normal.

A table holds little at theta_d = 0 itself (no instrument has its lamp in its lens), and
under the model f_r falls slowly with theta_d, so the mean over a few small theta_d at
phi_d = 90 degrees, where both directions are equally high, stands for backscatter.

The density serves to place nodes and to draw directions: what a file says of the BRDF is
f_r divided by it and multiplied again, so that nothing is lost where the model is wrong.

Reference: J. Dupuy, E. Heitz, J.-C. Iehl, P. Poulin, V. Ostromoukhov, "Extracting Microfacet-
based BRDF Parameters from Arbitrary Materials with Power Iterations", CGF 34(4), 2015;
Dupuy and Jakob 2018 (see `brdfit.formats.rgl.warp`), section 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray, safe_arccos
from brdfit.formats.rgl.warp import split
from brdfit.geometry import directions_from_half_diff

__all__ = ["Microsurface"]

# Twice as many columns as the MERL grid has nodes along the same square-root warp of theta_h.
_COLUMNS = 181
_SMALL_THETA_D = np.deg2rad([2.0, 8.0, 16.0, 24.0])
_ITERATIONS = 60
# Below this share of its maximum a density is noise, and dividing by it would amplify that.
_LEAST = 1e-5


@dataclass(frozen=True)
class Microsurface:
    """An isotropic microsurface, at columns u = sqrt(2 theta / pi) evenly in [0, 1]."""

    ndf: FloatArray
    """D (columns,), 1/sr, > 0; int D cos(theta) d(omega) = 1."""
    sigma: FloatArray
    """(columns,) projected area of the microsurface; 1 at the normal."""

    @classmethod
    def of(cls, brdf: Evaluable) -> Microsurface:
        """Return the microsurface whose backscatter is that of `brdf`, all channels together."""
        theta = np.linspace(0.0, 1.0, _COLUMNS) ** 2 * (np.pi / 2)
        source = np.cos(theta) * _backscatter(brdf, theta)
        area = _projected_area_operator(theta)
        ndf = source.copy()
        for _ in range(_ITERATIONS):
            ndf = source * (area @ ndf)
            ndf /= ndf.max()
        ndf = np.maximum(ndf, _LEAST)
        ndf /= _ring_weights(theta) @ (ndf * np.cos(theta))
        return cls(ndf, np.maximum(area @ ndf, _LEAST))

    def visible(self, u: FloatArray, cos_im: FloatArray) -> FloatArray:
        """Return the density of normals seen from wi, unnormalised, over (u, phi_m).

        `u` is the column of the normal, `cos_im` = wi . wm; the shape is that of both.
        """
        j, v = split(u, _COLUMNS)
        ndf = (1.0 - v) * self.ndf[j] + v * self.ndf[j + 1]
        # d(omega_m) = sin(theta_m) pi u du d(phi_m)
        return np.asarray(ndf * np.maximum(cos_im, 0.0) * u * np.sin(u * u * (np.pi / 2)))


def _backscatter(brdf: Evaluable, theta: FloatArray) -> FloatArray:
    """Return f_r (columns,) where light and detector are close, > 0, up to a factor."""
    theta_h, theta_d = np.meshgrid(np.minimum(theta, np.deg2rad(89.5)), _SMALL_THETA_D)
    wi, wo = directions_from_half_diff(theta_h.ravel(), theta_d.ravel(), np.full(1, np.pi / 2))
    value = np.maximum(brdf.evaluate(wi, wo), 0.0).mean(axis=1)
    mean = value.reshape(_SMALL_THETA_D.size, -1).mean(axis=0)
    if mean.max() <= 0.0:  # black: any density will do
        return np.ones_like(theta)
    return np.asarray(np.maximum(mean / mean.max(), _LEAST))


def _ring_weights(theta: FloatArray) -> FloatArray:
    """Return (columns,) with which a function of theta is integrated over the hemisphere."""
    u = np.sqrt(theta * (2.0 / np.pi))
    weight = 2.0 * np.pi * np.sin(theta) * np.pi * u / (theta.size - 1)
    weight[-1] /= 2.0
    return np.asarray(weight)


def _projected_area_operator(theta: FloatArray) -> FloatArray:
    """Return (columns, columns): applied to D it is sigma.

    Around a ring of normals w . m = a + b cos(phi); the part above 0 ends at
    phi = arccos(-a / b), or nowhere.
    """
    a = np.cos(theta)[:, None] * np.cos(theta)[None, :]
    b = np.sin(theta)[:, None] * np.sin(theta)[None, :]
    end = safe_arccos(-a / np.maximum(b, 1e-300))
    mean = (a * end + b * np.sin(end)) / np.pi
    return np.asarray(mean * _ring_weights(theta)[None, :])
