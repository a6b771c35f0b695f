"""One BRDF against another under every metric: on rendered spheres and in BRDF space.

comparison = compare(reference, test)
comparison.perceptual_error                      # mean CIEDE2000 under the studio
comparison.images["point"]["delta_e_itp"]
comparison.values["log_rms"]                     # value, entries used, entries skipped
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import MissingExtra, UsageError
from brdfit.geometry import cos_incident_outgoing
from brdfit.grid import Grid
from brdfit.metrics import METRICS, Score
from brdfit.progress import Progress, silent
from brdfit.reconstruct.result import Reconstruction
from brdfit.render import ILLUMINATIONS, Evaluable, ForDisplay, Sphere, to_rgb
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Comparison", "compare"]

_CHUNK = 100_000
# Where a function of direction, or a table of many bands, is compared: every second node of
# the MERL grid along each axis keeps 31 bands within memory.
_COARSE = Grid(45, 45, 90)
_FULL_GRID_CHANNELS = 3


@dataclass(frozen=True)
class Comparison:
    """How far a test BRDF is from its reference."""

    images: dict[str, dict[str, float]]
    """Illumination -> metric -> value, on a sphere; empty if the reference is samples."""
    values: dict[str, Score]
    """Metric in BRDF space -> value, entries used and skipped."""
    absent: dict[str, str]
    """Metric that could not be computed -> why, and what to do."""
    sphere_size: int
    """Pixels along an edge of the rendered images."""
    directions: int
    """Direction pairs compared in BRDF space."""
    channels: tuple[str, ...]
    """Channels compared in BRDF space."""
    notes: tuple[str, ...] = ()
    """What a reader of the figures has to know."""

    @property
    def perceptual_error(self) -> float:
        """Mean CIEDE2000 of the sphere under the studio; NaN if that was not rendered."""
        return self.images.get("studio", {}).get("perceptual_error", math.nan)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON-able values; what is not finite becomes a word."""
        return {
            "images": {
                light: {name: _plain(value) for name, value in found.items()}
                for light, found in self.images.items()
            },
            "values": {
                name: {"value": _plain(score.value), "used": score.used, "skipped": score.skipped}
                for name, score in self.values.items()
            },
            "absent": dict(self.absent),
            "sphere_size": self.sphere_size,
            "directions": self.directions,
            "channels": list(self.channels),
            "units": {name: metric.unit for name, metric in METRICS.items()},
            "higher_is_better": [
                name for name, metric in METRICS.items() if metric.higher_is_better
            ],
            "notes": list(self.notes),
        }


def compare(
    reference: Table | Samples | Evaluable,
    test: Table | Evaluable,
    *,
    illuminations: Sequence[str] = ("studio", "point"),
    size: int = 64,
    progress: Progress = silent,
) -> Comparison:
    """Return how far `test` is from `reference` under every metric.

    Images are spheres of `size` pixels under the built-in `illuminations`. In BRDF space a
    table is compared at the cells of its grid that are above the horizon, weighted by
    solid angle, cells that hold nothing skipped and counted; a function of direction, or a
    table of more than three channels, at the cells of a 45 x 45 x 90 grid. Samples
    are compared at their own directions, evenly weighted, without images. Where the two
    have different channels, both are taken to linear sRGB, and `notes` says so.
    """
    unknown = sorted(set(illuminations) - set(ILLUMINATIONS))
    if unknown:
        raise UsageError(
            f"illumination: found {unknown[0]!r} but there are {', '.join(ILLUMINATIONS)}."
        )
    points = _points(reference, test, progress)
    scores: dict[str, Score] = {}
    for metric in METRICS.values():
        if metric.compares == "values":
            score = metric.function(*points[:5])
            assert isinstance(score, Score)
            scores[metric.name] = score
    images: dict[str, dict[str, float]] = {}
    absent: dict[str, str] = {}
    if isinstance(reference, Samples):
        notes = (*points.notes, "the reference is samples: no sphere can be rendered from it")
    else:
        images, absent = _images(reference, test, illuminations, Sphere(size), progress)
        notes = points.notes
    return Comparison(
        images=images,
        values=scores,
        absent=absent,
        sphere_size=size,
        directions=len(points.reference),
        channels=points.channels,
        notes=notes,
    )


class _Points(NamedTuple):
    # the arguments of a metric in BRDF space, then what is to be said about them
    reference: FloatArray
    test: FloatArray
    cos_theta_i: FloatArray
    cos_theta_o: FloatArray
    weights: FloatArray | None
    channels: tuple[str, ...]
    notes: tuple[str, ...]


def _points(
    reference: Table | Samples | Evaluable, test: Table | Evaluable, progress: Progress
) -> _Points:
    if isinstance(reference, Samples):
        usable = np.where(reference.usable, reference.value, np.nan)
        rows = np.flatnonzero(reference.usable.any(axis=1))
        wi, wo = reference.wi[rows], reference.wo[rows]
        found = _evaluate(test, wi, wo, progress)
        a, b, channels, notes = _same_channels(reference, usable[rows], test, found)
        return _Points(a, b, wi[:, 2], wo[:, 2], None, channels, notes)
    grid = _COARSE
    if isinstance(reference, Table) and reference.n_channels <= _FULL_GRID_CHANNELS:
        grid = reference.grid
    values = [_at_cells(brdf, grid, progress) for brdf in (reference, test)]
    a, b, channels, notes = _same_channels(reference, values[0], test, values[1])
    cosines = cos_incident_outgoing(*grid.half_diff(grid.cells))
    weights = grid.solid_angle.reshape(-1)[grid.cells]
    where = f"compared at {grid.cells.size} cells of a {' x '.join(map(str, grid.shape))} grid"
    return _Points(a, b, *cosines, weights, channels, (where, *notes))


def _at_cells(brdf: Table | Evaluable, grid: Grid, progress: Progress) -> FloatArray:
    if isinstance(brdf, Table) and brdf.grid == grid:
        value = brdf.values.reshape(grid.size, -1)[grid.cells].astype(np.float64)
        value[~brdf.mask.reshape(-1)[grid.cells]] = np.nan
        return value
    return _evaluate(brdf, *grid.directions(grid.cells), progress)


def _evaluate(brdf: Evaluable, wi: FloatArray, wo: FloatArray, progress: Progress) -> FloatArray:
    parts = []
    progress("evaluate", 0, len(wi))
    for first in range(0, len(wi), _CHUNK):
        rows = slice(first, first + _CHUNK)
        parts.append(brdf.evaluate(wi[rows], wo[rows]))
        progress("evaluate", min(first + _CHUNK, len(wi)), len(wi))
    return np.concatenate(parts)


class _Bands(NamedTuple):
    wavelengths: FloatArray | None
    channels: tuple[str, ...]


def _bands(brdf: Table | Samples | Evaluable) -> _Bands:
    known = brdf.samples if isinstance(brdf, Reconstruction) else brdf
    if isinstance(known, Table | Samples):
        return _Bands(known.wavelengths, known.channels)
    return _Bands(None, ())


def _same_channels(
    reference: Table | Samples | Evaluable,
    a: FloatArray,
    test: Table | Evaluable,
    b: FloatArray,
) -> tuple[FloatArray, FloatArray, tuple[str, ...], tuple[str, ...]]:
    mine, other = _bands(reference), _bands(test)
    if a.shape[1] == b.shape[1] and _agree(mine, other):
        names = mine.channels or other.channels or tuple(map(str, range(a.shape[1])))
        return a, b, names, ()
    note = (
        f"the reference has {a.shape[1]} channels and the test {b.shape[1]} others: both were "
        f"taken to linear sRGB"
    )
    return to_rgb(a, *mine), to_rgb(b, *other), ("R", "G", "B"), (note,)


def _agree(mine: _Bands, other: _Bands) -> bool:
    if not mine.channels or not other.channels:
        # a plain function of direction says nothing of its channels
        return True
    if mine.wavelengths is None or other.wavelengths is None:
        return mine.wavelengths is other.wavelengths and mine.channels == other.channels
    return bool(np.allclose(mine.wavelengths, other.wavelengths))


def _images(
    reference: Table | Evaluable,
    test: Table | Evaluable,
    illuminations: Sequence[str],
    sphere: Sphere,
    progress: Progress,
) -> tuple[dict[str, dict[str, float]], dict[str, str]]:
    shown = [ForDisplay.of(brdf, *_bands(brdf)) for brdf in (reference, test)]
    images: dict[str, dict[str, float]] = {}
    absent: dict[str, str] = {}
    progress("render", 0, len(illuminations))
    for done, name in enumerate(illuminations):
        pair = [sphere.shade(brdf, ILLUMINATIONS[name]()) for brdf in shown]
        images[name] = {}
        for metric in METRICS.values():
            if metric.compares != "images":
                continue
            try:
                value = metric.function(*pair, sphere.mask)
            except MissingExtra as missing:
                absent[metric.name] = str(missing)
            else:
                assert isinstance(value, float)
                images[name][metric.name] = value
        progress("render", done + 1, len(illuminations))
    return images, absent


def _plain(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)
