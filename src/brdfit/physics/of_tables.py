"""The checks of a dense table."""

from __future__ import annotations

from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.geometry import cos_incident_outgoing
from brdfit.physics.albedo_plan import AlbedoPlan
from brdfit.physics.finding import Finding, Verdict
from brdfit.physics.verdicts import (
    GRAZING,
    RECIPROCITY_HELD,
    alignment_finding,
    cannot,
    energy_finding,
    graded,
    noise_finding,
    symmetry_finding,
)
from brdfit.table import Table

__all__ = ["table_findings"]

# Share of the domain that may hold nothing: (good below, wrong above).
_HOLES = (0.01, 0.2)
# Where a specular peak is looked for: theta_d in degrees; half angles beside it.
_PEAK_THETA_D = (5.0, 60.0)
_BESIDE = 30.0
_PROMINENT = 1.5
# Third differences (1, -3, 3, -1) of white noise of deviation 1 have deviation sqrt(20).
_THIRD = np.sqrt(20.0)
_TO_STDDEV = 1.4826
_ENOUGH = 50


def table_findings(table: Table) -> tuple[Finding, ...]:
    """Return what every check finds in `table`."""
    if not table.mask.any():
        names = ("energy", "grazing", "symmetry", "peak")
        empty = tuple(cannot(name, "no cell holds a value") for name in names)
        return (_cells(table), RECIPROCITY_HELD, *empty)
    log_f = _log_of(table)
    return (
        _cells(table),
        RECIPROCITY_HELD,
        _energy(table),
        _grazing(table, log_f),
        _symmetry(table, log_f),
        _peak(table, log_f),
    )


def _log_of(table: Table) -> FloatArray:
    """Return ln of the mean over channels, shaped as the grid; NaN where that is not positive."""
    mean = table.values.mean(axis=3, dtype=np.float64)
    good = table.mask & (mean > 0.0)
    return np.where(good, np.log(np.where(good, mean, 1.0)), np.nan)


def _cells(table: Table) -> Finding:
    measure = table.grid.solid_angle
    exists = table.grid.above_horizon
    missing = exists & ~table.mask
    negative = table.mask & (table.values < 0.0).any(axis=3)
    zero = table.mask & ~negative & (table.values == 0.0).any(axis=3)
    share = float(measure[missing | negative].sum())
    verdict = graded(share, _HOLES)
    if verdict is Verdict.GOOD and negative.any():
        verdict = Verdict.LOOK
    details = {
        "missing": int(missing.sum()),
        "negative": int(negative.sum()),
        "zero": int(zero.sum()),
        "missing_share": float(measure[missing].sum()),
        "negative_share": float(measure[negative].sum()),
    }
    sentence = _cells_in_words(table, details, int(exists.sum()))
    return Finding("cells", verdict, sentence, share, "share of the domain", details)


def _cells_in_words(table: Table, details: dict[str, Any], exists: int) -> str:
    parts = []
    if details["missing"]:
        parts.append(
            f"{details['missing']:,} hold nothing ({details['missing_share']:.1%} of the domain)"
        )
    if details["negative"]:
        lowest = table.values[table.mask].min(axis=0)
        channel = int(np.argmin(lowest))
        parts.append(
            f"{details['negative']:,} hold a negative value ({details['negative_share']:.1%}), "
            f"down to {lowest[channel]:.3g} 1/sr in {table.channels[channel]}"
        )
    if details["zero"]:
        parts.append(f"{details['zero']:,} hold a zero")
    if not parts:
        return f"all {exists:,} cells above the horizon hold values above zero"
    return f"of {exists:,} cells above the horizon {', '.join(parts)}"


def _energy(table: Table) -> Finding:
    plan = AlbedoPlan.build(table.grid, table.mask, table.grid.theta_d)
    return energy_finding(plan.theta_i, plan.of(table), table.channels, None)


def _grazing(table: Table, log_f: FloatArray) -> Finding:
    third = np.abs(np.diff(log_f, n=3, axis=1)) / _THIRD
    middle = _larger_angle(table)[:, 1:-2]
    grazing, inside = middle > np.radians(GRAZING), middle < np.radians(60.0)
    seen = np.isfinite(third)
    if (seen & grazing).sum() < _ENOUGH:
        return cannot("grazing", f"too few cells beyond {GRAZING:g} degrees hold a value")
    noise = _typical(third, seen & grazing)
    return noise_finding(noise, _typical(third, seen & inside), int((seen & grazing).sum()))


def _typical(size: FloatArray, where: BoolArray) -> float:
    return float(_TO_STDDEV * np.median(size[where])) if where.any() else 0.0


def _larger_angle(table: Table) -> FloatArray:
    grid = table.grid
    cosines = cos_incident_outgoing(
        grid.theta_h[:, None, None], grid.theta_d[None, :, None], grid.phi_d[None, None, :]
    )
    return np.asarray(np.arccos(np.clip(np.minimum(*cosines), 0.0, 1.0)))


def _symmetry(table: Table, log_f: FloatArray) -> Finding:
    # phi_d -> -phi_d, which reciprocity brings back to pi - phi_d
    mirrored = log_f[:, :, (-np.arange(table.grid.n_phi_d)) % table.grid.n_phi_d]
    difference = np.abs(log_f - mirrored)
    half = np.zeros(table.grid.shape, dtype=bool)
    half[1:, 1:, 1 : (table.grid.n_phi_d + 1) // 2] = True
    pairs = half & np.isfinite(difference)
    if pairs.sum() < _ENOUGH:
        return cannot("symmetry", "too few cells hold a value on both sides of the plane")
    found = difference[pairs]
    high = float(np.percentile(found, 95.0))
    return symmetry_finding(float(np.median(found)), high, int(pairs.sum()), "pairs of cells")


def _peak(table: Table, log_f: FloatArray) -> Finding:
    grid = table.grid
    rows = np.flatnonzero(
        (grid.theta_d >= np.radians(_PEAK_THETA_D[0]))
        & (grid.theta_d <= np.radians(_PEAK_THETA_D[1]))
    )
    positions, widths = [], []
    for row in rows:
        found = _peak_of(grid.theta_h, log_f[:, row])
        if found is not None:
            positions.append(found[0])
            widths.append(found[1])
    if len(positions) < max(3, rows.size // 2):
        return cannot("peak", "the table has no specular peak to speak of")
    at, width = float(np.median(positions)), float(np.median(widths))
    # A node is all that a table resolves, and a wide lobe has a flat top.
    node = float(np.interp(at, grid.theta_h[:-1], np.diff(grid.theta_h)))
    uncertainty = np.degrees(max(node, 0.1 * width))
    details = {"half_width_degrees": float(np.degrees(width)), "rows": len(positions)}
    what = f"its half width is {np.degrees(width):.1f} degrees"
    return alignment_finding(float(np.degrees(at)), float(uncertainty), what, details)


def _peak_of(theta_h: FloatArray, log_f: FloatArray) -> tuple[float, float] | None:
    """Return (position, half width at half maximum) of ln f (theta_h, phi_d), or None."""
    seen = np.isfinite(log_f)
    enough = seen.sum(axis=1) >= log_f.shape[1] // 2
    near = enough & (theta_h <= np.radians(_BESIDE))
    if near.sum() < 5 or not enough[:3].any():
        return None
    profile = np.where(seen, log_f, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    theta, height = theta_h[near], profile[near]
    top = int(np.argmax(height))
    if height[top] - height[-1] < np.log(_PROMINENT):
        return None
    fallen = np.flatnonzero(height[top:] < height[top] - np.log(2.0))
    half = theta[top + fallen[0]] - theta[top] if fallen.size else theta[-1]
    return float(theta[top]), float(half)
