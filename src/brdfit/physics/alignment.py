"""Where the specular peak stands: the alignment error of an instrument, in degrees.

Half vectors of mirror pairs are the normal. On an instrument whose sample is tilted, or one of
whose arms is off its zero, the lobe is centred on another half vector c. Around the peak

    ln(f cos theta_i cos theta_o) = a polynomial in theta_d + a falling function of |h - c|,

h the half vector laid into the surface, in radians; the cosines take out what masking and the
microfacet denominator shift. The falling function is piecewise linear over sqrt(|h - c|), its
second differences held small. For each c it is a linear fit, reweighted against outliers; c is
where the fit is best. The uncertainty follows from how fast the fit becomes worse; added to it
are a twentieth of the half width of the lobe, whose shape need not be that simple, and up to half
the spacing of the half vectors around the peak, between which a narrow one may hide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from brdfit.arrays import FloatArray, IntArray, normalize
from brdfit.physics.neighbourhood import mean_of_channels
from brdfit.samples import Samples

__all__ = ["Alignment", "find_alignment"]

_THETA_H = np.radians(20.0)
_THETA_D = np.radians(65.0)
# sqrt of radians: knots of the falling function
_KNOTS = np.sqrt(np.radians(25.0)) * np.linspace(0.0, 1.0, 12)
_SMOOTH = 3e-3
_OF_HALF_WIDTH = 0.05
_ENOUGH = 25
_MOST = 4000
_START = np.radians([-3.0, -1.0, 0.0, 1.0, 3.0])
# The lobe has to be this much higher than its surroundings to have a position.
_PROMINENT = 1.5
_STEP = np.radians(0.02)
_AROUND = np.radians(3.0)
_SAME_PLACE = np.radians(0.1)
# Misfits of the two frames that say nothing for either.
_ALIKE = 0.1


@dataclass(frozen=True)
class Alignment:
    """The centre of the specular lobe as a half vector."""

    along: float
    """Degrees in the plane of incidence, positive away from the light."""
    across: float
    """Degrees across it; 0 where no sample leaves the plane."""
    uncertainty: float
    """Standard deviation of either, degrees."""
    frame: str
    """"sample" (a tilt turns with the sample), "incidence" (the zero of an arm) or "either"."""
    samples: int

    @property
    def degrees(self) -> float:
        """Distance of the centre from the normal."""
        return float(np.hypot(self.along, self.across))


def find_alignment(samples: Samples) -> Alignment | None:
    """Return where the lobe of `samples` is centred; None where no peak is to be seen."""
    rows = np.flatnonzero(mean_of_channels(samples) > 0.0)
    theta_h, theta_d, _ = (angle[rows] for angle in samples.half_diff)
    rows = rows[(theta_h < _THETA_H) & (theta_d < _THETA_D)]
    if rows.size < _ENOUGH:
        return None
    rows = rows[:: max(1, rows.size // _MOST)]
    fits = [_LobeFit.of(samples, rows, frame) for frame in ("incidence", "sample")]
    if not all(fit.peaked for fit in fits):
        return None
    (misfit, one), (other_misfit, other) = (fit.solve() for fit in fits)
    if abs(misfit - other_misfit) < _ALIKE * max(misfit, other_misfit):
        return replace(one, frame="either")
    return one if misfit < other_misfit else other


@dataclass(frozen=True, eq=False)
class _LobeFit:
    h: FloatArray
    theta_d: FloatArray
    y: FloatArray
    frame: str

    @classmethod
    def of(cls, samples: Samples, rows: IntArray, frame: str) -> _LobeFit:
        wi, wo = samples.wi[rows], samples.wo[rows]
        wh = normalize(wi + wo)
        h = wh[:, :2]
        if frame == "incidence":
            # the light at azimuth pi: positive is away from it
            azimuth = np.arctan2(wi[:, 1], wi[:, 0]) + np.pi
            cos, sin = np.cos(azimuth), np.sin(azimuth)
            h = np.stack([cos * h[:, 0] + sin * h[:, 1], cos * h[:, 1] - sin * h[:, 0]], axis=1)
        y = np.log(mean_of_channels(samples)[rows] * wi[:, 2] * wo[:, 2])
        return cls(h, samples.half_diff[1][rows], y, frame)

    @property
    def planar(self) -> bool:
        """Whether no half vector leaves the plane of incidence by more than half a degree."""
        return bool(np.abs(self.h[:, 1]).max() < np.radians(0.5))

    @property
    def peaked(self) -> bool:
        """Whether values near the normal stand out from those beside it."""
        away = np.hypot(*self.h.T)
        order = np.argsort(away)
        inner, outer = self.y[order[: max(5, away.size // 10)]], self.y[order[-away.size // 4 :]]
        return bool(np.median(inner) - np.median(outer) > np.log(_PROMINENT))

    def solve(self) -> tuple[float, Alignment]:
        """Return (mean square residual, alignment)."""
        from scipy.optimize import minimize

        axes = 1 if self.planar else 2
        starts = np.array(np.meshgrid(*[_START] * axes)).reshape(axes, -1).T
        first = min(starts, key=self._misfit)
        simplex = np.vstack([first, first + np.radians(0.7) * np.eye(axes)])
        options = {"initial_simplex": simplex, "xatol": 1e-5, "fatol": 1e-12, "maxiter": 200}
        found = minimize(self._misfit, first, method="Nelder-Mead", options=options)
        centre = np.degrees(np.append(found.x, 0.0)[:2])
        alignment = Alignment(
            along=float(centre[0]),
            across=float(centre[1]),
            uncertainty=self._uncertainty(found.x, self._fit(found.x)),
            frame=self.frame,
            samples=len(self.y),
        )
        return float(found.fun), alignment

    def _uncertainty(self, centre: FloatArray, best: _Fitted) -> float:
        # chi^2 / n = misfit: its curvature along the flattest axis
        curvature = [
            self._fit(centre + step).misfit + self._fit(centre - step).misfit - 2.0 * best.misfit
            for step in _STEP * np.eye(centre.size)
        ]
        flattest = max(min(curvature) / _STEP**2, 1e-12)
        statistical = np.sqrt(2.0 * best.misfit / (len(self.y) * flattest))
        spacing = self._spacing(centre)
        hiding = 0.5 * spacing**2 / (spacing + best.half_width)
        parts = (statistical, _OF_HALF_WIDTH * best.half_width, hiding)
        return float(np.degrees(np.linalg.norm(parts)))

    def _spacing(self, centre: FloatArray) -> float:
        offset = self.h[:, : centre.size] - centre
        near = offset[(offset**2).sum(axis=1) < _AROUND**2]
        places = max(1, len(np.unique(np.rint(near / _SAME_PLACE), axis=0)))
        return float(2.0 * _AROUND / places if self.planar else _AROUND * np.sqrt(np.pi / places))

    def _misfit(self, centre: FloatArray) -> float:
        return self._fit(centre).misfit

    def _fit(self, centre: FloatArray) -> _Fitted:
        away = np.sqrt(np.sqrt(((self.h[:, : centre.size] - centre) ** 2).sum(axis=1)))
        t = self.theta_d[:, None]
        design = np.hstack([_hats(away), t**2, t**4])
        bend = np.zeros((_KNOTS.size - 2, design.shape[1]))
        bend[:, : _KNOTS.size] = np.diff(np.eye(_KNOTS.size), n=2, axis=0)
        held = _SMOOTH * len(away) * bend.T @ bend + 1e-9 * np.eye(design.shape[1])
        weight = np.ones_like(away)
        for _ in range(4):
            normal = (design * weight[:, None]).T @ design + held
            fit = np.linalg.solve(normal, design.T @ (weight * self.y))
            residual = self.y - design @ fit
            size = max(1.4826 * float(np.median(np.abs(residual))), 1e-6)
            weight = 1.0 / (1.0 + (residual / (2.5 * size)) ** 2)
        misfit = float((weight * residual**2).sum() / weight.sum())
        return _Fitted(misfit, _half_width(fit[: _KNOTS.size]))


class _Fitted(NamedTuple):
    misfit: float
    half_width: float


def _hats(x: FloatArray) -> FloatArray:
    """Return (n, knots): the shares of the knots on either side."""
    step = _KNOTS[1]
    apart = np.abs(np.minimum(x, _KNOTS[-1])[:, None] - _KNOTS)
    return np.asarray(np.maximum(0.0, 1.0 - apart / step))


def _half_width(height: FloatArray) -> float:
    """Return where ln f has fallen by ln 2, radians."""
    fine = np.linspace(0.0, _KNOTS[-1], 500)
    profile = np.interp(fine, _KNOTS, height)
    fallen = np.flatnonzero(profile < profile[0] - np.log(2.0))
    return float(fine[fallen[0]] ** 2 if fallen.size else _KNOTS[-1] ** 2)
