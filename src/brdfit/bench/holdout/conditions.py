"""Which part of a file is fitted, and what was done to it.

    share        a share of the usable samples at random, 20 % unless said otherwise
    100, 1000    so many of them
    100:factor   the same so many, 30 % of them spoilt by an outlier model
    blind        up to 1000, none of them from two of four bands of incidence angle; only these
                 bands are predicted

A condition that a file has too few samples for does not apply to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.bench.outliers import OUTLIER_MODELS, contaminate
from brdfit.bench.real_files import Split, generator, split
from brdfit.bench.verdicts import deviation
from brdfit.errors import UsageError
from brdfit.geometry import spherical_from_directions
from brdfit.samples import Samples

__all__ = ["BLIND", "CONDITIONS", "SHARE", "SPOILT", "Part", "part_of"]

SHARE, BLIND = "share", "blind"

CONDITIONS = (SHARE, "100", "1000", "100:factor", "1000:factor", BLIND)
"""Those that are run unless others are asked for."""

SPOILT = 0.3
"""Share of the fitted samples that an outlier model spoils."""

# What is fitted leaves at least this share of the usable samples to be predicted.
_LEAST_HELD_OUT = 0.2
_BANDS, _LEFT_OUT = 4, (1, 3)
_BLIND_SAMPLES = 1000
# Angles this close are the same incidence.
_SAME_DEGREES = 0.5


@dataclass(frozen=True, eq=False)
class Part:
    """A file taken apart.

    `planted` (n,) are the fitted samples that were spoilt, `moved` (n,) by how much in ln f_r.
    """

    fitted: Samples
    held_out: Samples
    planted: BoolArray
    moved: FloatArray


def part_of(name: str, samples: Samples, condition: str, how: Split) -> Part | None:
    """Return the parts of the samples called `name`; None where there are too few.

    Raises `UsageError` for a condition that does not exist.
    """
    if condition == SHARE:
        return _clean(*split(samples, how, name))
    if condition == BLIND:
        return _blind(name, samples, how)
    count, _, model = condition.partition(":")
    if not count.isdecimal() or int(count) < 1 or model not in {"", *OUTLIER_MODELS}:
        raise UsageError(
            f"--conditions: found {condition!r} but known are {SHARE}, {BLIND}, a number of "
            f"samples, and that with an outlier model, as in 1000:factor."
        )
    part = _counted(name, samples, int(count), how)
    return part if part is None or not model else _spoilt(name, part, model, how)


def _clean(fitted: Samples, held_out: Samples) -> Part:
    nobody = np.zeros(len(fitted), dtype=bool)
    return Part(fitted, held_out, nobody, np.zeros(len(fitted)))


def _counted(name: str, samples: Samples, count: int, how: Split) -> Part | None:
    rows = np.flatnonzero(samples.usable.any(axis=1))
    if count > (1.0 - _LEAST_HELD_OUT) * rows.size:
        return None
    order = generator(how.seed, name, str(count)).permutation(rows)
    return _clean(*(samples.subset(np.sort(part)) for part in (order[:count], order[count:])))


def _spoilt(name: str, part: Part, model: str, how: Split) -> Part:
    fitted = part.fitted
    rng = generator(how.seed, name, str(len(fitted)), model)
    theta_i, _ = spherical_from_directions(fitted.wi)
    wrong = contaminate(model, fitted.value, SPOILT, rng, theta_i)
    moved = deviation(fitted.value, wrong.values)
    return Part(fitted.with_value(wrong.values), part.held_out, wrong.mask, moved)


def _blind(name: str, samples: Samples, how: Split) -> Part | None:
    rows = np.flatnonzero(samples.usable.any(axis=1))
    band = _bands(np.degrees(spherical_from_directions(samples.wi[rows])[0]))
    aside = np.isin(band, _LEFT_OUT)
    if not aside.any() or aside.all():
        return None
    kept = generator(how.seed, name, BLIND).permutation(rows[~aside])[:_BLIND_SAMPLES]
    return _clean(samples.subset(np.sort(kept)), samples.subset(rows[aside]))


def _bands(degrees: FloatArray) -> IntArray:
    """Return the band of each angle (n,): four with about as many samples, equal angles together.

    From the normal to grazing; the second and the fourth are left out, one between others and
    one beyond them.
    """
    level = np.rint(degrees / _SAME_DEGREES).astype(np.int64)
    distinct, which, counts = np.unique(level, return_inverse=True, return_counts=True)
    middle = (np.cumsum(counts) - 0.5 * counts) / max(level.size, 1)
    if distinct.size < _BANDS:
        # fewer incidence angles than bands: the second and the fourth of them
        return np.ravel(which)
    if distinct.size <= 2 * _BANDS:
        middle = (np.arange(distinct.size) + 0.5) / distinct.size
    return np.asarray(np.floor(middle * _BANDS).astype(np.int64)[np.ravel(which)])
