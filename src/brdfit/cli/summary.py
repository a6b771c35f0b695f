"""What was read, in a few lines for a person and as values for a script."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.report.channels import channels_in_words
from brdfit.report.coverage import coverage_of

if TYPE_CHECKING:
    from brdfit.arrays import BoolArray, IntArray
    from brdfit.samples import Samples
    from brdfit.table import Table

__all__ = [
    "first_rows",
    "rows_in_words",
    "samples_lines",
    "samples_record",
    "table_lines",
    "table_record",
]

_ROWS_SHOWN = 5


def first_rows(samples: Samples, chosen: BoolArray) -> str:
    """Return "rows 3, 8, 21, ...": where the first few of `chosen` stand in the file."""
    index = np.flatnonzero(chosen)
    return rows_in_words(index + 1 if samples.rows is None else samples.rows[index])


def rows_in_words(rows: Sequence[int] | IntArray) -> str:
    """Return "rows 3, 8, 21, ..." of numbers that are known already."""
    shown = ", ".join(str(row) for row in rows[:_ROWS_SHOWN])
    more = ", ..." if len(rows) > _ROWS_SHOWN else ""
    return f"row{'s' if len(rows) > 1 else ''} {shown}{more}"


def samples_lines(samples: Samples) -> list[str]:
    """Return what a person wants to know of measurements before they are used."""
    usable = int(samples.usable.any(axis=1).sum())
    lines = [
        f"{samples.source.name}: {len(samples):,} samples, {channels_in_words(samples.channels)}, "
        f"{usable:,} usable",
        f"  format      {samples.source.format}",
    ]
    if samples.source.convention:
        lines.append(f"  convention  {samples.source.convention}")
    coverage = coverage_of(samples)
    lines.append(f"  coverage    {coverage if coverage is not None else 'nothing usable'}")
    lines += [f"  flagged     {line}" for line in _flag_lines(samples)] or ["  flagged     none"]
    lines += [f"  note        {note}" for note in samples.source.notes]
    return lines


def samples_record(samples: Samples) -> dict[str, Any]:
    """Return the same as JSON-able values."""
    coverage = coverage_of(samples)
    return {
        "kind": "samples",
        "count": len(samples),
        "usable": int(samples.usable.any(axis=1).sum()),
        "channels": list(samples.channels),
        "wavelengths": _numbers(samples.wavelengths),
        "flags": samples.flag_counts(),
        "coverage": None if coverage is None else coverage.record(),
        "ranges": _ranges(samples.value, samples.usable, samples.channels),
        "source": dataclasses.asdict(samples.source),
    }


def table_lines(table: Table) -> list[str]:
    """Return what a person wants to know of a table."""
    record = table_record(table)
    n_h, n_d, n_phi = table.grid.shape
    lines = [
        f"{table.source.name}: table of {n_h} x {n_d} x {n_phi} cells, "
        f"{channels_in_words(table.channels)}",
        f"  format      {table.source.format}",
    ]
    if table.source.convention:
        lines.append(f"  convention  {table.source.convention}")
    lines.append(
        f"  cells       {record['valid']:,} valid, {record['missing']:,} missing above the "
        f"horizon, {record['below_horizon']:,} below it"
    )
    for name, figures in list(record["ranges"].items())[:_ROWS_SHOWN]:
        if figures is not None:
            lines.append(
                f"  {name:<11} {figures['min']:.4g} to {figures['max']:.4g}, "
                f"median {figures['median']:.4g} 1/sr"
            )
    if len(record["ranges"]) > _ROWS_SHOWN:
        lines.append(f"  ...         {len(record['ranges']) - _ROWS_SHOWN} more channels")
    lines += [f"  note        {note}" for note in table.source.notes]
    return lines


def table_record(table: Table) -> dict[str, Any]:
    """Return the same as JSON-able values."""
    valid = int(table.mask.sum())
    return {
        "kind": "table",
        "shape": list(table.grid.shape),
        "channels": list(table.channels),
        "wavelengths": _numbers(table.wavelengths),
        "valid": valid,
        "missing": table.missing,
        "below_horizon": int((~table.grid.above_horizon).sum()),
        "ranges": _table_ranges(table),
        "source": dataclasses.asdict(table.source),
    }


def _flag_lines(samples: Samples) -> list[str]:
    from brdfit.samples import Flag

    lines = []
    for name, count in samples.flag_counts().items():
        chosen = (samples.bits & int(Flag[name.upper()])) != 0
        what = _MEANING.get(name, "")
        lines.append(f"{count:,} {name} ({what}): {first_rows(samples, chosen)}")
    return lines


_MEANING = {
    "not_finite": "no finite value; not used",
    "below_horizon": "light or detector at or below the horizon; not used",
    "not_unit": "a direction is no unit vector; not used",
    "censored": "zero or negative somewhere: an upper bound there",
    "partly_missing": "some channels are not finite; the others are used",
    "duplicate": "directions repeat an earlier sample's; used",
    "unreadable": "could not be read as numbers; not used",
    "rejected": "marked as wrong; not used",
}


def _numbers(array: Any) -> list[float] | None:
    return None if array is None else [float(number) for number in array]


def _ranges(value: Any, usable: Any, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: _figures(value[usable[:, c], c]) for c, name in enumerate(names)}


def _table_ranges(table: Table) -> dict[str, Any]:
    return {
        name: _figures(table.values[..., c][table.mask]) for c, name in enumerate(table.channels)
    }


def _figures(column: Any) -> dict[str, float] | None:
    if column.size == 0:
        return None
    return {
        "min": float(column.min()),
        "median": float(np.median(column)),
        "max": float(column.max()),
    }
