"""A GGX lobe over a Lambertian base for very many points at once, in closed form.

    f = d / pi + F L_alpha,     F = f0 (1 - p) + p,    p = (1 - cos theta_d)^5      (Schlick)

L_alpha is the lobe of roughness alpha without Fresnel (`interface.ggx_lobe`). For a given
alpha f is affine in (d, f0) of each channel: two weighted sums of squares decide, held within
[0, 1]. Of a list of alphas the one with the smallest sum over the channels wins, between its
neighbours by a parabola. A slight pull of f0 toward 0.04 decides where a lobe is so wide that it
could be the base as well. The weights are those of the cube root of f cos_i cos_o, which no
highlight owns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.export.interface import ggx_lobe, schlick
from brdfit.geometry import directions_from_half_diff
from brdfit.models import PairAngles

__all__ = ["TextureFit", "TexturePoints"]

_THETA_H = (0.0, 1.5, 3.0, 5.0, 8.0, 12.0, 17.0, 23.0, 30.0, 40.0, 52.0, 65.0)
_THETA_D = (3.0, 20.0, 40.0, 58.0)
_PHI_D = (0.0, 90.0)
_ROUGHNESS = np.linspace(0.08, 1.0, 32)
_USUAL_F0, _PULL = 0.04, 0.02
# f_r, 1/sr: below it a difference cannot be seen.
_DARK = 1e-3


@dataclass(frozen=True, eq=False)
class TexturePoints:
    """Parameters of n points; NaN where the point has none.

    | name        | shape  | meaning                                                        |
    |-------------|--------|----------------------------------------------------------------|
    | `diffuse`   | (n, c) | albedo of the base                                             |
    | `specular`  | (n, c) | f0, reflectance of the lobe at normal incidence                |
    | `roughness` | (n,)   | square root of alpha                                           |
    | `misfit`    | (n,)   | rms difference of ln f_r over the directions that were asked   |
    """

    diffuse: FloatArray
    specular: FloatArray
    roughness: FloatArray
    misfit: FloatArray


class TextureFit:
    """The directions that are asked, and the fit to values there."""

    @cached_property
    def directions(self) -> tuple[FloatArray, FloatArray]:
        """(wi, wo), each (m, 3): from the highlight to grazing."""
        angles = np.meshgrid(*(np.deg2rad(a) for a in (_THETA_H, _THETA_D, _PHI_D)), indexing="ij")
        wi, wo = directions_from_half_diff(*(a.ravel() for a in angles))
        above = np.minimum(wi[:, 2], wo[:, 2]) > 0.05
        return wi[above], wo[above]

    def fit(self, values: FloatArray) -> TexturePoints:
        """Return the parameters of values (n, m, c), f_r in 1/sr at `directions`."""
        cost = np.stack([self._solve(values, r)[2] for r in _ROUGHNESS], axis=1)
        roughness = _lowest(cost)
        result = [np.full(values.shape[::2], np.nan) for _ in range(2)]
        misfit = np.full(len(values), np.nan)
        good = np.isfinite(roughness)
        # the last step between the listed values: points of alike roughness together
        steps = np.round(np.where(good, roughness, 0.0), 2)
        for r in np.unique(steps[good]):
            at = good & (steps == r)
            diffuse, specular, _ = self._solve(values[at], r)
            result[0][at], result[1][at] = diffuse, specular
            lobe, fixed = self._lobe(r)
            found = diffuse[:, None] / np.pi + specular[:, None] * lobe[:, None] + fixed[:, None]
            off = np.log(np.maximum(found, _DARK)) - np.log(np.maximum(values[at], _DARK))
            misfit[at] = np.sqrt((off**2).mean(axis=(1, 2)))
        return TexturePoints(result[0], result[1], np.where(good, steps, np.nan), misfit)

    def _lobe(self, roughness: float) -> tuple[FloatArray, FloatArray]:
        """Return (what f0 multiplies, what is there without it), each (m,)."""
        angles = PairAngles.of(*self.directions)
        lobe = ggx_lobe(angles, float(roughness) ** 2)[:, 0]
        grazing = schlick(angles.cos_d[:, 0], 0.0)
        return lobe * (1.0 - grazing), lobe * grazing

    def _solve(
        self, values: FloatArray, roughness: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return (diffuse (n, c), f0 (n, c), cost (n,)) of one roughness."""
        lobe, fixed = self._lobe(roughness)
        weight = self._weight(values)
        target = values - fixed[:, None]
        base = np.full(len(lobe), 1.0 / np.pi)
        bb, bl, ll = (
            np.einsum("nmc,m->nc", weight, product)
            for product in (base * base, base * lobe, lobe * lobe)
        )
        pull = _PULL * ll
        by, ly = (np.einsum("nmc,m->nc", weight * target, basis) for basis in (base, lobe))
        ll, ly = ll + pull, ly + pull * _USUAL_F0
        with np.errstate(invalid="ignore", divide="ignore"):
            f0 = np.clip((bb * ly - bl * by) / np.maximum(bb * ll - bl * bl, 1e-30), 0.0, 1.0)
            diffuse = np.clip((by - bl * f0) / bb, 0.0, 1.0)
            f0 = np.clip((ly - bl * diffuse) / ll, 0.0, 1.0)
        rest = target - diffuse[:, None] * base[:, None] - f0[:, None] * lobe[:, None]
        cost = np.einsum("nmc,nmc->n", weight, rest * rest)
        return diffuse, f0, cost + (pull * (f0 - _USUAL_F0) ** 2).sum(axis=1)

    def _weight(self, values: FloatArray) -> FloatArray:
        """Return squared weights (n, m, c): the slope of the cube root of f cos_i cos_o."""
        wi, wo = self.directions
        cosine = (wi[:, 2] * wo[:, 2]) ** (2.0 / 3.0)
        return np.asarray(cosine[:, None] / np.maximum(values, _DARK) ** (4.0 / 3.0))


def _lowest(cost: FloatArray) -> FloatArray:
    """Return the roughness (n,) of least cost (n, roughnesses), between neighbours."""
    good = np.asarray(np.isfinite(cost).all(axis=1))
    safe = np.where(good[:, None], cost, 0.0)
    best = np.clip(np.argmin(safe, axis=1), 1, len(_ROUGHNESS) - 2)
    row = np.arange(len(cost))
    low, middle, high = (safe[row, best + k] for k in (-1, 0, 1))
    bend = low - 2.0 * middle + high
    shift = np.where(bend > 0.0, 0.5 * (low - high) / np.where(bend > 0.0, bend, 1.0), 0.0)
    step = _ROUGHNESS[1] - _ROUGHNESS[0]
    found = _ROUGHNESS[best] + step * np.clip(shift, -1.0, 1.0)
    return np.where(good, found, np.nan)
