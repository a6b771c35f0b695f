"""Messages about items: what the page is told of a table, a fit, its samples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.formats import list_formats
from brdfit.geometry import spherical_from_directions, wrap_phi_d
from brdfit.report.fit_figure import slices_of
from brdfit.report.reading_options import READING_OPTIONS
from brdfit.report.samples_csv import Judged
from brdfit.samples import Flag
from brdfit.viewer.item import Item
from brdfit.viewer.messages import (
    Albedo,
    Entry,
    FitSummary,
    SampleColumns,
    SamplesSummary,
    Setting,
    Writable,
)

__all__ = [
    "albedo_message",
    "columns_message",
    "entry_message",
    "number",
    "reading_settings",
    "writable",
]

# A map with more dots than this shows no more, and a browser slows down.
_MOST_SHOWN = 20_000


def number(value: Any, digits: int = 7) -> float | None:
    """Return a float of so many significant digits, or None where it is not finite."""
    plain = float(value)
    return float(f"{plain:.{digits}g}") if np.isfinite(plain) else None


def numbers(values: FloatArray, digits: int = 6) -> list[float | None]:
    """Return a column for JSON."""
    return [number(value, digits) for value in values]


def entry_message(item: Item) -> Entry:
    """Return what the page is told of an item first."""
    _, conversion = item.in_colour
    return Entry(
        id=item.id,
        name=item.name,
        kind="table" if item.fitted.judged is None else "reconstruction",
        grid=list(item.table.grid.shape),
        scale=item.packed.scale,
        channels=list(item.table.channels),
        conversion=str(conversion),
        missing=item.table.missing,
        samples=None if item.fitted.judged is None else _samples(item.fitted.judged),
        fit=_fit(item) if item.record else None,
        warnings=[*item.warnings, *item.fitted.notes],
        writable=writable(item),
        parent=item.parent,
    )


def _samples(judged: Judged) -> SamplesSummary:
    samples = judged.samples
    return SamplesSummary(
        count=len(samples),
        used=int(samples.usable.any(axis=1).sum()),
        outliers=int(judged.outliers.sum()),
        rejected=int(np.count_nonzero(samples.bits & int(Flag.REJECTED))),
        flags=samples.flag_counts(),
        source=samples.source.name,
        convention=samples.source.convention,
        incidences=[round(float(np.degrees(one.theta_i)), 1) for one in slices_of(samples)],
    )


def _fit(item: Item) -> FitSummary:
    record = item.record
    method = dict(_part(record, "method"))
    outcome, residuals = _part(record, "outcome"), _part(record, "residuals")
    name = str(method.pop("name", "?"))
    return FitSummary(
        method=name,
        settings={key: str(value) for key, value in method.items()},
        population=str(_part(record, "population").get("name", "")),
        outcome=str(outcome.get("name", "?")),
        ok=bool(outcome.get("ok", False)),
        advice=str(outcome.get("advice", "")),
        iterations=int(record.get("iterations", 0)),
        residual_before=_part(residuals, "before").get("median_abs"),
        residual_after=_part(residuals, "after").get("median_abs"),
        outlier_rule=str(_part(record, "outliers").get("rule", "")),
        live=item.result is not None,
    )


def _part(record: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    part = record.get(name)
    return part if isinstance(part, Mapping) else {}


def writable(item: Item) -> list[Writable]:
    """Return every format that the item can be downloaded in."""
    found = [
        Writable(sheet.name, "table", sheet.title, sheet.extensions[0], sheet.loses)
        for sheet in list_formats()
        if sheet.write_table is not None
    ]
    if item.fitted.judged is not None:
        found += [
            Writable(sheet.name, "samples", sheet.title, sheet.extensions[0], sheet.loses)
            for sheet in list_formats()
            if sheet.write_samples is not None
        ]
    if item.record:
        found.append(Writable("record", "record", "record of the fit (JSON)", ".json", ""))
    return found


def reading_settings() -> list[Setting]:
    """Return what can be said of a file that is read, as a form shows it."""
    return [
        Setting(option.name, option.help, option.kind, None, list(option.choices))
        for option in READING_OPTIONS
    ]


def albedo_message(item: Item) -> Albedo:
    """Return what an even surround adds."""
    cosine, value = item.albedo
    return Albedo(cosine.tolist(), np.nan_to_num(value).tolist())


def columns_message(judged: Judged) -> SampleColumns:
    """Return the samples as columns; of very many every k-th, and all outliers."""
    samples = judged.samples
    shown = _shown(judged.outliers)
    theta_i, phi_i = spherical_from_directions(samples.wi[shown])
    theta_o, phi_o = spherical_from_directions(samples.wo[shown])
    theta_h, theta_d, phi_d = (angle[shown] for angle in samples.half_diff)
    turn = np.mod(phi_o - phi_i, 2.0 * np.pi)
    usable = samples.usable[shown]
    residuals = np.where(usable, judged.residuals[shown], np.nan)
    return SampleColumns(
        sample=shown.tolist(),
        row=np.asarray(judged.rows)[shown].tolist(),
        theta_h=numbers(np.degrees(theta_h)),
        theta_d=numbers(np.degrees(theta_d)),
        phi_d=numbers(np.degrees(wrap_phi_d(phi_d))),
        theta_i=numbers(np.degrees(theta_i)),
        theta_o=numbers(np.degrees(theta_o)),
        turn=numbers(np.degrees(turn)),
        value=numbers(_mean(samples.value[shown])),
        residual=numbers(_mean(residuals)),
        weight=numbers(judged.weights[shown]),
        outlier=judged.outliers[shown].tolist(),
        used=np.asarray(usable.any(axis=1)).tolist(),
        left_out=len(samples) - shown.size,
    )


def _shown(outliers: BoolArray) -> IntArray:
    n = outliers.size
    step = max(1, -(-n // _MOST_SHOWN))
    return np.flatnonzero(outliers | (np.arange(n) % step == 0))


def _mean(values: FloatArray) -> FloatArray:
    """Return the mean over the finite channels (n,), NaN where there is none."""
    finite = np.isfinite(values)
    count = finite.sum(axis=1)
    total = np.where(finite, values, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
