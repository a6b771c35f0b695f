"""What a report says, section by section: everything that the template needs, worked out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.physics import Health, Verdict, examine
from brdfit.progress import Progress, silent
from brdfit.report.compare import Comparison
from brdfit.report.coverage import coverage_of
from brdfit.report.fitted import Fitted
from brdfit.report.page.lists import (
    FlagLine,
    MetricTable,
    OutlierLine,
    albedo_plot,
    flag_lines,
    look_up,
    metric_tables,
    outlier_lines,
    settings_lines,
)
from brdfit.report.page.pictures import SphereRow, sphere_rows
from brdfit.report.page.slices import slice_data, slice_plots, slices_to_draw, styles_of
from brdfit.report.page.trust import Trust, trust_of
from brdfit.report.page.words import count, number, percent, size_of_file
from brdfit.report.rgb import rgb_table
from brdfit.table import Table

__all__ = ["Contents", "Figure", "SliceSection", "contents_of"]


@dataclass(frozen=True)
class Figure:
    """A key figure at the top."""

    name: str
    value: str
    note: str = ""
    verdict: str = ""
    """Style: good, look, wrong, or none."""


@dataclass(frozen=True)
class HealthSection:
    """The findings about one content."""

    title: str
    health: Health
    plot: str
    """SVG, or empty."""


@dataclass(frozen=True)
class SliceSection:
    """Slices as data for the script, and as plots without it."""

    data: dict[str, Any]
    plots: tuple[tuple[str, str], ...]
    channels: tuple[tuple[str, str], ...]
    """(name, style) of each curve."""
    has_band: bool
    has_samples: bool


@dataclass(frozen=True)
class Contents:
    """All sections of a report."""

    name: str
    summary: str
    advice: str
    ok: bool
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
    figures: tuple[Figure, ...]
    spheres: tuple[SphereRow, ...]
    conversion: str
    slices: SliceSection
    trust: Trust | None
    outlier_channels: tuple[str, ...]
    outliers: tuple[OutlierLine, ...]
    outlier_count: int
    outlier_rule: str
    flags: tuple[FlagLine, ...]
    health: tuple[HealthSection, ...]
    metrics: tuple[MetricTable, ...]
    reference: str
    metric_notes: tuple[str, ...]
    made: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    """(heading, lines) of how it was made."""
    files: tuple[tuple[str, str, str, str], ...]
    """(role, name, size, SHA-256)."""
    record: str
    """The record of the fit as JSON, without the numbers of its uncertainty."""


def contents_of(
    fitted: Fitted,
    comparison: Comparison | None = None,
    reference: Table | None = None,
    reference_name: str = "",
    progress: Progress = silent,
) -> Contents:
    """Work out what is said of `fitted`, and how it compares with a reference.

    `reference` is rendered beside it, where it is a table.
    """
    spheres = sphere_rows(fitted.table, reference, progress)
    health = _health(fitted)
    judged, record = fitted.judged, fitted.record
    index = _listed_channels(fitted)
    outcome = look_up(record, "outcome")
    return Contents(
        name=fitted.name,
        summary=_summary(fitted),
        advice=str(look_up(outcome or {}, "advice") or ""),
        ok=bool(look_up(outcome or {}, "ok")) if outcome else True,
        notes=fitted.notes,
        warnings=tuple(str(warning) for warning in _list(look_up(record, "warnings"))),
        figures=tuple(_figures(fitted, health, comparison)),
        spheres=tuple(spheres),
        conversion=str(rgb_table(fitted.table)[1]),
        slices=_slices(fitted),
        trust=_trust(fitted),
        outlier_channels=tuple(judged.samples.channels[c] for c in index) if judged else (),
        outliers=tuple(outlier_lines(judged, index)) if judged else (),
        outlier_count=int(judged.outliers.sum()) if judged else 0,
        outlier_rule=str(look_up(record, "outliers", "rule") or ""),
        flags=tuple(flag_lines(judged)) if judged else (),
        health=tuple(health),
        metrics=tuple(metric_tables(comparison)) if comparison else (),
        reference=reference_name,
        metric_notes=_metric_notes(comparison),
        made=tuple(_made(fitted)),
        files=tuple((f.role, f.name, size_of_file(f.size), f.sha256) for f in fitted.files),
        record=_record_text(fitted),
    )


def _summary(fitted: Fitted) -> str:
    n_h, n_d, n_phi = fitted.table.grid.shape
    channels = fitted.table.channels
    named = ", ".join(channels) if len(channels) <= 4 else f"{channels[0]} to {channels[-1]}"
    text = (
        f"A BRDF of {len(channels)} channel{'s' if len(channels) > 1 else ''} ({named}) on "
        f"{n_h} × {n_d} × {n_phi} nodes"
    )
    method, outcome = (look_up(fitted.record, *keys) for keys in _HOW)
    if method and outcome:
        return f"{text}, reconstructed by the method {method}; the fit ended: {outcome}."
    return f"{text}."


_HOW = (("method", "name"), ("outcome", "name"))


def _figures(
    fitted: Fitted, health: list[HealthSection], comparison: Comparison | None
) -> list[Figure]:
    figures = []
    if fitted.judged is not None:
        figures += _sample_figures(fitted)
    worst = next((v for v in _WORST if any(one.health.worst is v for one in health)), None)
    if worst is not None:
        figures.append(Figure("Physical health", _VERDICT[worst], "worst finding", str(worst)))
    if comparison is not None and np.isfinite(comparison.perceptual_error):
        value = number(comparison.perceptual_error)
        figures.append(Figure("Perceptual error", value, "mean CIEDE2000 against the reference"))
    return figures


_WORST = (Verdict.WRONG, Verdict.LOOK, Verdict.GOOD)
_VERDICT = {Verdict.WRONG: "wrong", Verdict.LOOK: "worth a look", Verdict.GOOD: "good"}


def _sample_figures(fitted: Fitted) -> list[Figure]:
    judged = fitted.judged
    assert judged is not None
    used = int(judged.samples.usable.any(axis=1).sum())
    wrong = int(judged.outliers.sum())
    residuals = np.abs(judged.residuals[~judged.outliers])
    finite = residuals[np.isfinite(residuals)]
    figures = [
        Figure("Measurements used", count(used), f"of {count(len(judged.samples))}"),
        Figure("Outliers", count(wrong), f"{percent(wrong / max(used, 1))} of those used"),
    ]
    if finite.size:
        misfit = percent(float(np.expm1(np.median(finite))))
        figures.append(Figure("Typical misfit", misfit, "median, outliers left out"))
    coverage = coverage_of(judged.samples)
    if coverage is not None:
        near = f"of the domain within {coverage.near:g}° of a measurement"
        figures.append(Figure("Measured", percent(coverage.share), near))
    return figures


def _listed_channels(fitted: Fitted) -> list[int]:
    from brdfit.report.channels import shown_channels

    if fitted.judged is None:
        return []
    samples = fitted.judged.samples
    return [one.channel for one in shown_channels(samples.n_channels, samples.wavelengths)]


def _slices(fitted: Fitted) -> SliceSection:
    slices = slices_to_draw(fitted)
    curves = slices.panels[0].curves
    styles = styles_of(len(curves))
    return SliceSection(
        data=slice_data(slices),
        plots=tuple(slice_plots(slices)),
        channels=tuple((c.channel, s) for c, s in zip(curves, styles, strict=True)),
        has_band=any(curve.low is not None for curve in curves),
        has_samples=any(panel.points for panel in slices.panels),
    )


def _trust(fitted: Fitted) -> Trust | None:
    if fitted.judged is None:
        return None
    coverage = coverage_of(fitted.judged.samples)
    if coverage is None:
        return None
    leans = bool(look_up(fitted.record, "population", "name"))
    supplier = "the population" if leans else "the method"
    return trust_of(fitted.judged.samples, coverage, supplier, fitted.trust)


def _health(fitted: Fitted) -> list[HealthSection]:
    found = [("The reconstruction", examine(fitted.table))]
    if fitted.judged is not None and fitted.judged.samples.usable.any():
        found.append(("The measurements", examine(fitted.judged.samples)))
    return [HealthSection(title, health, albedo_plot(health)) for title, health in found]


def _metric_notes(comparison: Comparison | None) -> tuple[str, ...]:
    if comparison is None:
        return ()
    absent = [f"{name} could not be computed: {why}" for name, why in comparison.absent.items()]
    return (*comparison.notes, *absent)


def _made(fitted: Fitted) -> list[tuple[str, tuple[tuple[str, str], ...]]]:
    record = fitted.record
    source = look_up(record, "samples", "source")
    if source is None and fitted.judged is None:
        source = {
            "name": fitted.table.source.name,
            "format": fitted.table.source.format,
            "sha256": fitted.table.source.sha256,
            "convention": fitted.table.source.convention,
            "notes": list(fitted.table.source.notes),
        }
    parts = {
        "Measurement" if record else "File": source,
        "Method and its settings": look_up(record, "method"),
        "Population": look_up(record, "population"),
        "Channels written": look_up(record, "channels_written"),
        "Software that fitted": look_up(record, "versions"),
    }
    found = [(title, tuple(settings_lines(values))) for title, values in parts.items()]
    return [(title, lines) for title, lines in found if lines]


def _record_text(fitted: Fitted) -> str:
    if not fitted.record:
        return ""
    shown, left_out = dict(fitted.record), {"values": "left out here; the record has them"}
    stated, trust = shown.get("uncertainty"), shown.get("trust")
    if isinstance(stated, dict):
        shown["uncertainty"] = {**stated, **left_out}
    if isinstance(trust, dict) and isinstance(trust.get("prior"), dict):
        shown["trust"] = {**trust, "prior": {**trust["prior"], **left_out}}
    return json.dumps(shown, indent=1, ensure_ascii=False, default=str)


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []
