"""Slices in the plane of incidence, with the measurements near them: as data and as plots.

The data are what the page's script draws for any angle of incidence; the plots, of the
angles with the most measurements, stand in for it on paper and without a script.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from brdfit.report.drawn import drawn_samples, stddev_of
from brdfit.report.fit_figure import slices_of
from brdfit.report.fitted import Fitted
from brdfit.report.page.svg import Plot, Scale, decades
from brdfit.report.slice_panel import NearPoint, SlicePanel, slice_panel
from brdfit.report.uncertainty import NORMAL_95
from brdfit.samples import Samples

__all__ = ["Slices", "slice_data", "slice_plots", "slices_to_draw", "styles_of"]

_STEP = 2.5
_LAST = 87.5
_USUAL = (15.0, 45.0, 65.0)
# An angle of the light that this many measurements share gets a slice of its own.
_OWN_SLICE = 8
_MOST_OWN = 24


class Slices(NamedTuple):
    """The slices of a report."""

    panels: list[SlicePanel]
    """By angle of incidence, ascending."""
    measured: list[float]
    """Angles at which the light itself was measured, degrees; the others lie between."""
    busiest: list[float]
    """Three angles with the most measurements, ascending; usual ones without samples."""
    start: float
    """The angle to begin with."""


def slices_to_draw(fitted: Fitted) -> Slices:
    """Return a slice every 2.5 degrees, and at each angle that was measured often."""
    samples, outliers = drawn_samples(fitted)
    own = _own_angles(samples)
    busiest, start = list(_USUAL), _USUAL[1]
    if samples is not None:
        chosen = slices_of(samples)
        busiest = [round(float(np.degrees(one.theta_i)), 2) for one in chosen]
        start = busiest[int(np.argmax([len(one.rows) for one in chosen]))]
    stated = fitted.uncertainty
    deviations = NORMAL_95 if stated is None else stated.deviations_95
    angles = np.unique([*np.arange(0.0, _LAST + _STEP, _STEP), *own, *busiest])
    panels = [
        slice_panel(
            fitted.table,
            samples,
            outliers,
            stddev_of(fitted),
            theta_i=float(angle),
            deviations=deviations,
        )
        for angle in angles
        if angle <= _LAST
    ]
    return Slices(panels, own, busiest, start)


def _own_angles(samples: Samples | None) -> list[float]:
    if samples is None:
        return []
    used = samples.usable.any(axis=1)
    theta_i = np.round(np.degrees(np.arccos(np.clip(samples.wi[used, 2], -1.0, 1.0))), 1)
    angle, number = np.unique(theta_i, return_counts=True)
    often = (number >= _OWN_SLICE) & (angle <= _LAST)
    most = np.argsort(-number[often], kind="stable")[:_MOST_OWN]
    return sorted(float(one) for one in angle[often][most])


def slice_data(slices: Slices) -> dict[str, Any]:
    """Return what the script draws from, as JSON-able values of few digits.

    All panels share one `theta_o`; a curve has its value and, where it is known, the ends
    of its band; a point is [sample, row, curve, theta_o, value, outlier].
    """
    first = slices.panels[0]
    channels = [curve.channel for curve in first.curves]
    return {
        "theta_o": first.theta_o,
        "channels": [
            {"channel": channel, "style": style}
            for channel, style in zip(channels, styles_of(len(channels)), strict=True)
        ],
        "measured": slices.measured,
        "start": slices.start,
        "panels": [
            {
                "theta_i": panel.theta_i,
                "curves": [
                    {name: _plain(getattr(curve, name)) for name in ("value", "low", "high")}
                    for curve in panel.curves
                ],
                "points": [
                    _point(point, channels.index(point.channel))
                    for point in panel.points
                    if point.used
                ],
                "points_left_out": panel.points_left_out,
            }
            for panel in slices.panels
        ],
    }


def _point(point: NearPoint, curve: int) -> list[float]:
    value = float(f"{point.value:.4g}")
    return [point.sample, point.row, curve, point.theta_o, value, int(point.outlier)]


def _plain(values: list[float] | None) -> list[float | None] | None:
    """Return numbers of four digits; None, which is null in JSON, for what is not finite."""
    if values is None:
        return None
    return [float(f"{v:.4g}") if np.isfinite(v) else None for v in values]


def slice_plots(slices: Slices) -> list[tuple[str, str]]:
    """Return (caption, SVG) at the three angles with the most measurements."""
    chosen = [panel for panel in slices.panels if panel.theta_i in slices.busiest]
    return [(f"theta_i = {panel.theta_i:g}°", _plot(panel)) for panel in chosen]


def _plot(panel: SlicePanel) -> str:
    theta_o = np.asarray(panel.theta_o)
    styles = styles_of(len(panel.curves))
    curves = [np.asarray(curve.value) for curve in panel.curves]
    points = [point for point in panel.points if point.used and point.value > 0.0]
    floor = min((float(c[c > 0.0].min()) for c in curves if (c > 0.0).any()), default=0.1) / 30.0
    values = np.array([point.value for point in points if point.value > floor])
    low, high = decades(np.concatenate([*curves, values]))
    plot = Plot(
        Scale.linear(-90.0, 90.0, range(-90, 91, 30), "theta_o, degrees (mirror side > 0)"),
        Scale.log(low, high, "f_r, 1/sr"),
        f"f_r in the plane of incidence at theta_i = {panel.theta_i:g} degrees, with "
        f"{len({point.sample for point in points})} measurements near it",
    )
    for curve, value, style in zip(panel.curves, curves, styles, strict=True):
        if curve.low is not None and curve.high is not None:
            plot.band(theta_o, np.asarray(curve.low), np.asarray(curve.high), f"band {style}")
        plot.line(theta_o, value, f"curve {style}")
    names = [curve.channel for curve in panel.curves]
    for point in points:
        style = "outlier" if point.outlier else styles[names.index(point.channel)]
        place = np.array([point.theta_o]), np.array([point.value])
        plot.marks(*place, f"mark {style}", cross=point.outlier)
    return plot.markup()


def styles_of(curves: int) -> tuple[str, ...]:
    """Return the classes of that many curves: R, G, B, or ink and greys."""
    return ("red", "green", "blue") if curves == 3 else ("ink", "dim")[:curves]
