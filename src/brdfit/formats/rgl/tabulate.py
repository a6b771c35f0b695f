"""A BRDF in the adaptive parameterisation: where the nodes go, and what stands at them.

The nodes follow a density that for a part is that of the visible normals, which crowds them
where a glossy BRDF changes, and for the rest even over the square of normals, so that the
other directions keep nodes too. Renderers draw directions by this density times the luminance
at the nodes, so that it need not be the BRDF's own to be drawn from well.

Normals whose reflection would go below the surface get no nodes, but for a margin. What stands
there is 0, as in the database: a value that went on below zero would be closer near the horizon,
but it makes some of what renderers interpolate above it negative.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brdfit.albedo import Evaluable, directional_albedo
from brdfit.arrays import FloatArray
from brdfit.formats.rgl.measurement import Measurement
from brdfit.formats.rgl.microsurface import Microsurface
from brdfit.formats.rgl.parameterisation import Parameterisation
from brdfit.geometry import directions_from_spherical

__all__ = ["Resolution", "tabulated"]

# 0.1 degrees above the horizon: the last incidence at which there is a BRDF to ask.
_LAST = np.deg2rad(89.9)
# > 1 sets the angles of incidence denser toward the horizon, where reflection changes fastest.
_DENSER = 1.3
# Angles are added where the albedo between two of them would be farther off than this.
_ALBEDO_OFF = 0.003
_CANDIDATES = np.deg2rad(np.arange(0.5, 90.0, 0.5))
_RULE = {"rings": 64, "spokes": 8}
_EVEN_SHARE = 0.75
# Reflected directions down to this cosine get nodes, fewer the lower they are.
_MARGIN = 0.15
_BLOCK = 1 << 18


@dataclass(frozen=True)
class Resolution:
    """How many nodes."""

    incidences: int
    """Angles of incidence; up to half as many more where the albedo needs them."""
    nodes: int
    """Nodes along each axis of the warped square."""
    density: int
    """Nodes along each axis of the densities that place them."""

    def size(self, channels: int) -> int:
        """Return the bytes that a file of so many channels takes at most, about."""
        values = self.nodes**2 * (channels + 1)
        return 4 * (self.incidences + self.incidences // 2) * (values + self.density**2)


def tabulated(brdf: Evaluable, resolution: Resolution) -> Measurement:
    """Return `brdf` as a measurement with nodes where it needs them.

    The measurement has neither wavelengths nor a description: those are not the BRDF's.
    """
    surface = Microsurface.of(brdf)
    theta_i = _as_stored(_incidences(brdf, resolution.incidences))
    blank = Measurement(
        theta_i=theta_i,
        ndf=_as_stored(np.stack([surface.ndf, surface.ndf])),
        sigma=_as_stored(np.stack([surface.sigma, surface.sigma])),
        vndf=_as_stored(np.stack([_density(surface, a, resolution.density) for a in theta_i])),
        values=np.ones((theta_i.size, resolution.nodes, resolution.nodes, 1)),
        wavelengths=None,
        jacobian=True,
        bits=None,
        description="",
    )
    wi, wo, scale = Parameterisation.of(blank).nodes()
    weighted = _weighted(brdf, wi.reshape(-1, 3), wo.reshape(-1, 3))
    values = (weighted / scale.reshape(-1, 1)).reshape(*scale.shape[:3], -1)
    return replace(blank, values=values, bits=wo[..., 2] > 0.0)


def _incidences(brdf: Evaluable, count: int) -> FloatArray:
    """Return `count` angles of incidence, and up to half as many more, ascending.

    Between two of them a renderer takes the mean of what is stored there. Where reflection rises
    and falls within a step, as at the last incidence that was measured, that is not close enough.
    """
    chosen = _LAST * (1.0 - np.linspace(1.0, 0.0, count) ** _DENSER)
    albedo = directional_albedo(brdf, _CANDIDATES, **_RULE)
    scale = np.maximum(np.abs(albedo).max(axis=1), 1e-300)
    known = directional_albedo(brdf, chosen, **_RULE)
    for _ in range(count // 2):
        between = np.stack([np.interp(_CANDIDATES, chosen, a) for a in known.T], axis=1)
        off = np.abs(between - albedo).max(axis=1) / scale
        worst = int(np.argmax(off))
        if off[worst] <= _ALBEDO_OFF:
            break
        at = int(np.searchsorted(chosen, _CANDIDATES[worst]))
        chosen = np.insert(chosen, at, _CANDIDATES[worst])
        known = np.insert(known, at, albedo[worst], axis=0)
    return np.asarray(chosen)


def _as_stored(array: FloatArray) -> FloatArray:
    # what a reader will find, so that what is divided out here is what it multiplies by
    return array.astype(np.float32).astype(np.float64)


def _density(surface: Microsurface, theta_i: float, size: int) -> FloatArray:
    """Return the density of nodes (size, size) over the square of phi_m, theta_m."""
    u = np.linspace(0.0, 1.0, size)
    phi_m, u = np.meshgrid((2.0 * u - 1.0) * np.pi, u, indexing="ij")
    wm = directions_from_spherical(u * u * (np.pi / 2), phi_m)
    wi = directions_from_spherical(np.array(theta_i), np.array(0.0))
    cos_im = wm @ wi
    height = 2.0 * cos_im * wm[..., 2] - wi[2]
    leaves = np.clip(1.0 + height / _MARGIN, 0.0, 1.0) * (cos_im > 0.0)
    visible = surface.visible(u, cos_im) * leaves
    visible /= visible.mean()
    return np.asarray((1.0 - _EVEN_SHARE) * visible + _EVEN_SHARE * leaves / leaves.mean())


def _weighted(brdf: Evaluable, wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return f_r cos(theta_o) (n, channels), 0 where wo is below the horizon."""
    parts = [
        brdf.evaluate(wi[start : start + _BLOCK], wo[start : start + _BLOCK])
        for start in range(0, len(wi), _BLOCK)
    ]
    return np.concatenate(parts) * np.maximum(wo[:, 2:], 0.0)
