"""One slice through a BRDF for an interactive plot: curves, their band, the samples nearby.

    panel = slice_panel(result, result.samples, result.outliers, theta_i=45.0)
    panel.curves[0].value          # f_r against panel.theta_o, a channel each

The plane holds the normal; the light is at the polar angle `theta_i`, the detector at
`theta_o`, positive on the side of azimuth `phi` from the light (180 degrees: the plane of
incidence, the mirror direction at theta_o = theta_i).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical, spherical_from_directions
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.channels import shown_channels
from brdfit.report.uncertainty import NORMAL_95
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Curve", "NearPoint", "SlicePanel", "Stddev", "slice_panel"]

Stddev = Callable[[FloatArray, FloatArray], FloatArray]
"""`stddev(wi, wo)`: standard deviation of ln f_r (n, channels), or (n, 1) for all of them."""

# How far a sample may lie from the plane and from the angle of the light, in degrees.
_PLANE, _ANGLE = 5.0, 3.0
_LAST = 89.0
_STEP = 0.5
# So many points tell a person as much as all of them.
_MOST_POINTS = 1500


@dataclass(frozen=True)
class Curve:
    """f_r of one channel along the slice, 1/sr; the band holds 95 % where it is known."""

    channel: str
    colour: str
    value: list[float]
    low: list[float] | None
    high: list[float] | None


@dataclass(frozen=True)
class NearPoint:
    """A measured value near the slice."""

    sample: int
    """Index of the sample, from 0."""
    row: int
    """Line or record of the source, from 1."""
    channel: str
    colour: str
    theta_o: float
    """Signed, degrees."""
    value: float
    """f_r as measured, 1/sr."""
    outlier: bool
    used: bool


@dataclass(frozen=True)
class SlicePanel:
    """What one interactive slice shows; all angles in degrees."""

    theta_i: float
    phi: float
    """Azimuth between light and detector on the positive side."""
    theta_o: list[float]
    curves: list[Curve]
    points: list[NearPoint]
    points_left_out: int
    """How many more measured values lie near the slice than are drawn."""


def slice_panel(
    brdf: Evaluable,
    samples: Samples | None = None,
    outliers: BoolArray | None = None,
    stddev: Stddev | None = None,
    *,
    theta_i: float,
    phi: float = 180.0,
    deviations: float = NORMAL_95,
) -> SlicePanel:
    """Return the slice of `brdf` at `theta_i` in [0, 89] and `phi`, degrees.

    `outliers` (n,) marks samples; `stddev` gives the band, `deviations` of them wide
    to either side, where it is known. A sample is
    near if its light, or by reciprocity its detector, is within 3 degrees of `theta_i` and
    the two directions are within 5 degrees of the plane.
    """
    if not 0.0 <= theta_i <= _LAST:
        raise UsageError(f"theta_i: found {theta_i:g} but expected 0 to {_LAST:g} degrees.")
    theta_o = np.arange(-_LAST, _LAST + _STEP / 2, _STEP)
    wi, wo = _directions(theta_i, theta_o, phi)
    value = brdf.evaluate(wi, wo)
    half = None if stddev is None else np.broadcast_to(deviations * stddev(wi, wo), value.shape)
    names, wavelengths = _bands(brdf, samples, value.shape[1])
    curves = [
        _curve(names[c], colour, value[:, c], None if half is None else half[:, c])
        for c, colour in shown_channels(value.shape[1], wavelengths)
    ]
    points: list[NearPoint] = []
    if samples is not None:
        points = _near(samples, theta_i, phi, outliers)
    step = max(1, -(-len(points) // _MOST_POINTS))
    kept = [point for n, point in enumerate(points) if point.outlier or n % step == 0]
    left_out = len(points) - len(kept)
    return SlicePanel(theta_i, phi, theta_o.tolist(), curves, kept, left_out)


def _directions(theta_i: float, theta_o: FloatArray, phi: float) -> tuple[FloatArray, FloatArray]:
    wi = directions_from_spherical(np.full(theta_o.shape, np.radians(theta_i)), np.zeros(1))
    wo = directions_from_spherical(np.radians(theta_o), np.full(1, np.radians(phi)))
    return wi, wo


def _bands(
    brdf: Evaluable, samples: Samples | None, n: int
) -> tuple[tuple[str, ...], FloatArray | None]:
    known = brdf.samples if isinstance(brdf, Reconstruction) else brdf
    if isinstance(known, Table | Samples):
        return known.channels, known.wavelengths
    if samples is not None and samples.n_channels == n:
        return samples.channels, samples.wavelengths
    return tuple(f"channel{index}" for index in range(n)), None


def _curve(channel: str, colour: str, value: FloatArray, half_width: FloatArray | None) -> Curve:
    if half_width is None:
        return Curve(channel, colour, value.tolist(), None, None)
    factor = np.exp(half_width)
    return Curve(
        channel, colour, value.tolist(), (value / factor).tolist(), (value * factor).tolist()
    )


def _near(
    samples: Samples, theta_i: float, phi: float, outliers: BoolArray | None
) -> list[NearPoint]:
    index, signed = _near_plane(samples, theta_i, phi)
    wrong = np.zeros(len(samples), dtype=bool) if outliers is None else outliers
    rows = np.arange(1, len(samples) + 1) if samples.rows is None else samples.rows
    return [
        NearPoint(
            sample=int(i),
            row=int(rows[i]),
            channel=samples.channels[c],
            colour=colour,
            theta_o=round(float(theta_o), 3),
            value=float(samples.value[i, c]),
            outlier=bool(wrong[i]),
            used=bool(samples.usable[i, c]),
        )
        for c, colour in shown_channels(samples.n_channels, samples.wavelengths)
        for i, theta_o in zip(index, signed, strict=True)
        if np.isfinite(samples.value[i, c])
    ]


def _near_plane(samples: Samples, theta_i: float, phi: float) -> tuple[IntArray, FloatArray]:
    """Return (which samples, their signed theta_o in degrees), light and detector exchanged too."""
    found: dict[int, float] = {}
    with np.errstate(invalid="ignore"):
        for fixed, free in ((samples.wo, samples.wi), (samples.wi, samples.wo)):
            theta_fixed, phi_fixed = spherical_from_directions(fixed)
            theta_free, phi_free = spherical_from_directions(free)
            turn = phi_free - phi_fixed - np.radians(phi)
            # By mirror symmetry a detector at -phi is one at +phi.
            other = phi_fixed - phi_free - np.radians(phi)
            turn = np.where(np.abs(np.sin(other)) < np.abs(np.sin(turn)), other, turn)
            aside = np.minimum(np.sin(theta_fixed), np.sin(theta_free)) * np.abs(np.sin(turn))
            near = aside < np.sin(np.radians(_PLANE))
            near &= np.abs(np.degrees(theta_fixed) - theta_i) < _ANGLE
            near &= (theta_fixed < np.pi / 2) & (theta_free < np.pi / 2)
            signed = np.degrees(np.where(np.cos(turn) >= 0.0, theta_free, -theta_free))
            found.update({int(i): float(signed[i]) for i in np.flatnonzero(near)})
    index = np.array(sorted(found), dtype=np.int64)
    return index, np.array([found[int(i)] for i in index], dtype=np.float64)
