"""Read RGL's measurements, as the samples that were measured or as a table."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import UsageError
from brdfit.files import sha256_of_bytes
from brdfit.formats.rgl import CONVENTION
from brdfit.formats.rgl.measurement import Measurement, measurement_from_bytes
from brdfit.formats.rgl.parameterisation import Parameterisation
from brdfit.grid import MERL_GRID
from brdfit.samples import Flag, Samples, Source
from brdfit.table import Table

__all__ = ["read_samples", "read_table"]

# Incidence closer to the horizon than this (rad) cannot have been measured.
_GRAZING = 1e-3
# The two halves of a measurement are one another's mirror image if that close.
_MIRRORED = 1e-2
# Closer to the horizon than 3 degrees f_r cos(theta_o) says nothing of f_r.
_LOWEST = np.sin(np.deg2rad(3.0))
_BLOCK = 1 << 17
_MOST_TABLE_BYTES = 1 << 30


def read_samples(path: Path, *, half: bool = False) -> Samples:
    """Return every node of the measurement as a sample, in the order of the file.

    Flagged, not dropped: `BELOW_HORIZON`, nodes whose wo is at or below the horizon (their
    value is NaN, since f_r is not defined there); `REJECTED`, nodes above the horizon that
    the file marks as invalid, and all of an incidence at 90 degrees, which nobody can
    measure: its nodes repeat those of the incidence before it.

    Most files hold every measurement twice, mirrored at the plane of incidence: a split
    into fitted and held-out samples that ignores it predicts copies. `half=True` reads one
    side only.
    """
    content = path.read_bytes()
    measurement = measurement_from_bytes(content, path.name)
    wi, wo, cosine_weighted = Parameterisation.of(measurement).nodes()
    horizontal = measurement.theta_i > np.pi / 2 - _GRAZING
    above = (wo[..., 2] > 0.0) & (wi[..., 2] > 0.0)
    cos_o = np.where(above, wo[..., 2], np.nan)
    value = cosine_weighted / cos_o[..., None]
    rejected = _marked_invalid(measurement, above) | (above & horizontal[:, None, None])
    notes = [*_notes(measurement, horizontal), *_mirror_notes(measurement, above, half)]
    keep = np.ones(above.shape, dtype=bool)
    if half:
        # rows run over phi_m from -pi to pi; the upper half is one side
        keep[:, : above.shape[1] // 2] = False
    channels = measurement.values.shape[3]
    return Samples(
        wi=wi[keep],
        wo=wo[keep],
        value=value[keep].reshape(-1, channels),
        wavelengths=measurement.wavelengths,
        flags=np.where(rejected, int(Flag.REJECTED), 0)[keep],
        rows=1 + np.flatnonzero(keep),
        source=_source(path, content, measurement, notes),
    )


def read_table(path: Path, *, extrapolate: bool = False) -> Table:
    """Return the measurement on the MERL grid.

    A cell holds the mean of f_r(wi, wo) and f_r(wo, wi): a table has one value for both,
    the measurement has two. Beyond the last measured incidence (about 80 degrees) the
    other order alone answers; cells where both directions lie beyond it are not valid.
    With `extrapolate=True` they hold what the authors' evaluator gives there, which
    keeps the last measured node values.

    The file holds f_r cos(theta_o) at nodes of which some are above the horizon and some below;
    it is not 0 at the horizon, and divided by the cosine it would grow without bound. Closer
    than 3 degrees to the horizon a cell therefore holds what is found 3 degrees above it.

    Values can be slightly negative (linear sRGB of a dark or saturated colour).
    """
    content = path.read_bytes()
    measurement = measurement_from_bytes(content, path.name)
    channels = measurement.values.shape[3]
    needed = MERL_GRID.size * channels * 8
    if needed > _MOST_TABLE_BYTES:
        raise UsageError(
            f"{path.name}: a dense table of its {channels} channels would take "
            f"{needed / 2**30:.1f} GiB. Read it with brdfit.read_samples."
        )
    parameterisation = Parameterisation.of(measurement)
    limit = np.cos(_last_measured(measurement))
    values = np.zeros((*MERL_GRID.shape, channels))
    flat = values.reshape(-1, channels)
    valid = np.zeros(MERL_GRID.size, dtype=bool)
    for start in range(0, MERL_GRID.cells.size, _BLOCK):
        cells = MERL_GRID.cells[start : start + _BLOCK]
        wi, wo = MERL_GRID.directions(cells)
        flat[cells], measured = _reciprocal(parameterisation, wi, wo, limit)
        valid[cells] = measured | extrapolate
    values.flags.writeable = False
    notes = _notes(measurement, measurement.theta_i > np.pi / 2 - _GRAZING)
    notes.append("within 3 degrees of the horizon values are those 3 degrees above it")
    beyond = int(np.count_nonzero(~valid[MERL_GRID.cells]))
    if beyond:
        notes.append(
            f"{beyond:,} cells with both directions beyond the last measured incidence are not "
            f"valid; extrapolate=True fills them as the authors' evaluator does"
        )
    return Table(
        values,
        grid=MERL_GRID,
        valid=valid.reshape(MERL_GRID.shape),
        wavelengths=measurement.wavelengths,
        source=_source(path, content, measurement, notes),
    )


def _reciprocal(
    parameterisation: Parameterisation, wi: FloatArray, wo: FloatArray, limit: float
) -> tuple[FloatArray, BoolArray]:
    """Return the mean over both orders (n, channels) and whether either was measured."""
    forward, backward = wi[:, 2] >= limit, wo[:, 2] >= limit
    neither = ~(forward | backward)
    share = np.where(forward | neither, 1.0, 0.0), np.where(backward | neither, 1.0, 0.0)
    total = share[0][:, None] * parameterisation.evaluate(wi, _raised(wo))
    total += share[1][:, None] * parameterisation.evaluate(wo, _raised(wi))
    return total / (share[0] + share[1])[:, None], ~neither


def _raised(w: FloatArray) -> FloatArray:
    """Return directions (n, 3), those close to the horizon lifted off it, azimuth kept."""
    z = np.maximum(w[:, 2], _LOWEST)
    flat = np.sqrt((1.0 - z * z) / np.maximum(1.0 - w[:, 2] ** 2, 1e-12))
    return np.column_stack([w[:, :2] * np.where(z > w[:, 2], flat, 1.0)[:, None], z])


def _last_measured(measurement: Measurement) -> float:
    below_horizon = measurement.theta_i[measurement.theta_i <= np.pi / 2 - _GRAZING]
    return float(below_horizon[-1]) if below_horizon.size else 0.0


def _marked_invalid(measurement: Measurement, above: BoolArray) -> BoolArray:
    """Return the nodes above the horizon that `valid` does not accept.

    Both senses of the bits occur in the database; the one that accepts more of the nodes
    above the horizon and fewer of those below is taken.
    """
    if measurement.bits is None:
        return np.zeros(above.shape, dtype=bool)
    set_means_valid = np.count_nonzero(measurement.bits == above) * 2 >= above.size
    accepted = measurement.bits if set_means_valid else ~measurement.bits
    return np.asarray(above & ~accepted)


def _notes(measurement: Measurement, horizontal: BoolArray) -> list[str]:
    notes = []
    if horizontal.any():
        last = np.degrees(_last_measured(measurement))
        notes.append(
            f"the incidence at 90 degrees was not measured; the last measured is {last:.1f} degrees"
        )
    if measurement.wavelengths is None:
        notes.append("RGB is linear sRGB and can be slightly negative")
    return notes


def _mirror_notes(measurement: Measurement, above: BoolArray, half: bool) -> list[str]:
    if half:
        return ["only the half with phi_m > 0 was read"]
    both = above & above[:, ::-1]
    values, mirrored = measurement.values[both], measurement.values[:, ::-1][both]
    if not both.any():
        return []
    with np.errstate(invalid="ignore"):
        apart = np.median(np.abs(values - mirrored) / (np.abs(values) + np.abs(mirrored) + 1e-30))
    if not apart < _MIRRORED:
        return []
    return [
        "every measurement occurs twice, mirrored at the plane of incidence; half=True reads one "
        "side only"
    ]


def _source(path: Path, content: bytes, measurement: Measurement, notes: list[str]) -> Source:
    return Source(
        name=path.name,
        format="rgl",
        sha256=sha256_of_bytes(content),
        convention=CONVENTION,
        notes=tuple(notes),
        metadata={"description": measurement.description} if measurement.description else {},
    )
