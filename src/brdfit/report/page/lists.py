"""The lists of the page: outliers, unused rows, findings, metrics, how it was made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from brdfit.geometry import spherical_from_directions
from brdfit.metrics import METRICS
from brdfit.physics import Health
from brdfit.report.compare import Comparison
from brdfit.report.page.svg import Plot, Scale
from brdfit.report.page.words import count, factor, number, weight
from brdfit.report.samples_csv import Judged
from brdfit.samples import Flag

__all__ = [
    "FlagLine",
    "MetricTable",
    "OutlierLine",
    "albedo_plot",
    "flag_lines",
    "look_up",
    "metric_tables",
    "outlier_lines",
    "settings_lines",
]

MOST_OUTLIERS = 100
_MOST_ROWS = 40
_HIGHEST_ALBEDO = 1.6


class OutlierLine(NamedTuple):
    """A measurement that was not believed."""

    row: int
    theta_i: str
    phi_i: str
    theta_o: str
    phi_o: str
    measured: tuple[str, ...]
    """f_r of each shown channel."""
    off: str
    """How far from the result, in words."""
    weight: str


class FlagLine(NamedTuple):
    """A kind of trouble with samples, and where."""

    name: str
    meaning: str
    total: str
    rows: str


@dataclass(frozen=True)
class MetricTable:
    """The metrics of one comparison."""

    title: str
    lines: tuple[tuple[str, str, str], ...]
    """(what, value with unit, which way is better)."""


def outlier_lines(judged: Judged, channels: list[int]) -> list[OutlierLine]:
    """Return the outliers, those farthest from the result first, at most `MOST_OUTLIERS`."""
    samples = judged.samples
    index = np.flatnonzero(judged.outliers)
    # a row without any finite residual is an outlier without a size: last
    residual = np.array([_mean(judged.residuals[row]) for row in index])
    order = np.argsort(-np.abs(np.nan_to_num(residual)), kind="stable")[:MOST_OUTLIERS]
    theta_i, phi_i = (np.degrees(angle) for angle in spherical_from_directions(samples.wi))
    theta_o, phi_o = (np.degrees(angle) for angle in spherical_from_directions(samples.wo))
    rows = judged.rows
    return [
        OutlierLine(
            row=rows[row],
            theta_i=f"{theta_i[row]:.1f}",
            phi_i=f"{phi_i[row]:.1f}",
            theta_o=f"{theta_o[row]:.1f}",
            phi_o=f"{phi_o[row]:.1f}",
            measured=tuple(number(float(samples.value[row, channel])) for channel in channels),
            off=factor(float(residual[place])),
            weight=weight(float(judged.weights[row])),
        )
        for place, row in ((place, index[place]) for place in order)
    ]


def _mean(residuals: Any) -> float:
    finite = residuals[np.isfinite(residuals)]
    return float(finite.mean()) if finite.size else float("nan")


def flag_lines(judged: Judged) -> list[FlagLine]:
    """Return what is wrong with samples by their values or by the file, where there is any."""
    rows = np.asarray(judged.rows)
    lines = []
    for flag in Flag:
        found = np.flatnonzero(judged.samples.bits & flag)
        if found.size:
            shown = ", ".join(str(row) for row in rows[found[:_MOST_ROWS]])
            more = f", and {count(found.size - _MOST_ROWS)} more" if found.size > _MOST_ROWS else ""
            name = str(flag.name).lower().replace("_", " ")
            lines.append(FlagLine(name, _MEANING[flag], count(found.size), shown + more))
    return lines


_MEANING = {
    Flag.NOT_FINITE: "no finite value or direction; not used",
    Flag.BELOW_HORIZON: "light or detector at or below the horizon; not used",
    Flag.NOT_UNIT: "a direction is no unit vector; not used",
    Flag.CENSORED: "zero or negative in some channel; used as an upper bound there",
    Flag.PARTLY_MISSING: "some channels are missing; the others are used",
    Flag.DUPLICATE: "repeats the directions of an earlier one; used",
    Flag.UNREADABLE: "the row could not be read; not used",
    Flag.REJECTED: "marked as wrong by the file or by a person; not used",
}


def metric_tables(comparison: Comparison) -> list[MetricTable]:
    """Return the metrics on rendered images, then those in BRDF space."""
    tables = []
    for light, found in comparison.images.items():
        title = f"Rendered sphere of {comparison.sphere_size} pixels, illumination {light}"
        lines = [_metric_line(name, value, "") for name, value in found.items()]
        tables.append(MetricTable(title, tuple(lines)))
    title = f"Values at {count(comparison.directions)} pairs of directions"
    lines = [
        _metric_line(name, score.value, f"{count(score.skipped)} skipped" if score.skipped else "")
        for name, score in comparison.values.items()
    ]
    return [*tables, MetricTable(title, tuple(lines))]


def _metric_line(name: str, value: float, note: str) -> tuple[str, str, str]:
    metric = METRICS[name]
    better = "higher is better" if metric.higher_is_better else "lower is better"
    shown = f"{number(value)} {metric.unit}".strip()
    return metric.title, f"{shown} ({note})" if note else shown, better


def albedo_plot(health: Health) -> str:
    """Return the directional albedo over incidence, SVG; empty where it is not known."""
    details = health["energy"].details
    if not details:
        return ""
    curves = {name: np.asarray(values) for name, values in details["albedo"].items()}
    largest = max(float(values.max()) for values in curves.values())
    # what is far above 1 is wrong by its size; the rest should stay readable
    top = float(np.clip(1.05 * largest, 1.1, _HIGHEST_ALBEDO))
    plot = Plot(
        Scale.linear(0.0, 90.0, range(0, 91, 15), "theta_i, degrees"),
        Scale.linear(0.0, top, np.arange(0.0, top + 0.01, 0.25).tolist(), "directional albedo"),
        "directional albedo over the angle of incidence; 1 is all the light that arrives",
    )
    plot.across(1.0, "all the light that arrives")
    if largest > top:
        plot.across(top, f"rises to {number(largest)}")
    styles = ("red", "green", "blue") if len(curves) == 3 else ("ink",) * len(curves)
    for values, style in zip(curves.values(), styles, strict=True):
        plot.line(np.asarray(details["theta_i_degrees"]), values, f"curve {style}")
    return plot.markup()


def look_up(record: Mapping[str, Any], *keys: str) -> Any:
    """Return the value under nested `keys`; None where the record has no such thing."""
    value: Any = record
    for key in keys:
        if not isinstance(value, Mapping):
            return None
        value = value.get(key)
    return value


def settings_lines(values: Any) -> list[tuple[str, str]]:
    """Return (name, value in words) of a mapping; nothing for anything else."""
    if not isinstance(values, Mapping):
        return []
    return [(str(name).replace("_", " "), in_words(value)) for name, value in values.items()]


def in_words(value: Any) -> str:
    """Return a JSON-able value as a person reads it."""
    if value is None:
        return "not set"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return number(value, 6).rstrip("0").rstrip(".") if value % 1 else f"{value:g}"
    if isinstance(value, list):
        # sentences want more between them than words
        between = "; " if any(" " in str(item) for item in value) else ", "
        return between.join(in_words(item) for item in value)
    if isinstance(value, Mapping):
        return "; ".join(f"{key}: {in_words(item)}" for key, item in value.items())
    return str(value)
