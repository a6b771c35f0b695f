"""Named ways in which measurements go wrong, so that robustness can be measured.

An outlier model spoils exactly round(ratio n) of n samples and says which: it maps values
(n, channels) to values of the same shape and a mask (n,). A wrong measurement is wrong in all
channels together, because one wrong direction, one reflection of the lamp, one
shadow spoils them all. Each model is a pure function of its arguments and the random
generator handed in; nothing else is random.

    factor     times a factor drawn log-uniformly from [1/10, 10], one per sample (default)
    uniform    u times each channel's 99th percentile, one u from [0, 1] per sample
    permute    the value that was measured at the direction of another chosen sample
    shadow     times a factor drawn log-uniformly from [1/1000, 1/100]: nearly black
    saturate   the brightest samples, scaled down to the brightness that is left
    cluster    a window of incidence angles, all times one factor: a whole run went wrong

The first three hit random samples and so does `shadow`; `saturate` and `cluster` choose by
brightness and by incidence angle, which is what makes them agree with one another.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, as_columns
from brdfit.errors import UsageError

__all__ = ["DEFAULT_OUTLIERS", "OUTLIER_MODELS", "Contaminated", "contaminate"]

FACTOR = 10.0
"""`factor` and `cluster` draw from [1 / FACTOR, FACTOR]."""

SHADOW = (1e-3, 1e-2)
"""`shadow` leaves this much of a value."""

PERCENTILE = 99.0
"""`uniform` reaches up to this percentile of each channel."""


@dataclass(frozen=True, eq=False)
class Contaminated:
    """Values (n, channels) of which the rows of `mask` (n,) are wrong."""

    values: FloatArray
    mask: BoolArray


OutlierModel = Callable[[FloatArray, FloatArray, int, np.random.Generator], Contaminated]
"""`model(values, theta_i, count, rng)` spoils exactly `count` rows."""


def contaminate(
    model: str,
    values: FloatArray,
    ratio: float,
    rng: np.random.Generator,
    theta_i: FloatArray | None = None,
) -> Contaminated:
    """Return a copy of `values` (n, channels) with exactly round(ratio n) rows spoilt.

    `theta_i` (n,) are incidence angles in radians; only `cluster` needs them. The same
    generator state gives the same result.
    """
    values = as_columns("values", values, len(values))
    if model not in OUTLIER_MODELS:
        raise UsageError(
            f"outlier model: found {model!r} but known are {', '.join(OUTLIER_MODELS)}."
        )
    if not 0.0 <= ratio <= 1.0:
        raise UsageError(f"outlier ratio: found {ratio!r} but a share is between 0 and 1.")
    if model == "cluster" and theta_i is None:
        raise UsageError("outlier model 'cluster' needs theta_i, the incidence angles (n,).")
    count = round(ratio * len(values))
    angles = np.zeros(len(values)) if theta_i is None else np.asarray(theta_i, dtype=np.float64)
    if count == 0:
        return Contaminated(values.copy(), np.zeros(len(values), dtype=bool))
    return OUTLIER_MODELS[model](values, angles, count, rng)


def _factor(
    values: FloatArray, theta_i: FloatArray, count: int, rng: np.random.Generator
) -> Contaminated:
    rows = _random_rows(len(values), count, rng)
    factor = _log_uniform(1.0 / FACTOR, FACTOR, count, rng)
    return _replaced(values, rows, values[rows] * factor[:, None])


def _uniform(
    values: FloatArray, theta_i: FloatArray, count: int, rng: np.random.Generator
) -> Contaminated:
    rows = _random_rows(len(values), count, rng)
    top = np.nanpercentile(values, PERCENTILE, axis=0)
    return _replaced(values, rows, rng.random(count)[:, None] * top[None, :])


def _permute(
    values: FloatArray, theta_i: FloatArray, count: int, rng: np.random.Generator
) -> Contaminated:
    rows = _random_rows(len(values), count, rng)
    if count > 1:
        # A cycle through the chosen in random order: nobody keeps his own value.
        return _replaced(values, rows, values[np.roll(rows, 1)])
    other = (rows + rng.integers(1, max(len(values), 2))) % len(values)
    return _replaced(values, rows, values[other])


def _shadow(
    values: FloatArray, theta_i: FloatArray, count: int, rng: np.random.Generator
) -> Contaminated:
    rows = _random_rows(len(values), count, rng)
    return _replaced(values, rows, values[rows] * _log_uniform(*SHADOW, count, rng)[:, None])


def _saturate(
    values: FloatArray, theta_i: FloatArray, count: int, rng: np.random.Generator
) -> Contaminated:
    brightness = np.nanmean(values, axis=1)
    order = np.argsort(-brightness, kind="stable")
    rows = order[:count]
    # The clip level is what the brightest of the others has; where all are hit, the darkest's.
    level = brightness[order[min(count, len(order) - 1)]]
    safe = np.where(brightness[rows] > 0.0, brightness[rows], 1.0)
    return _replaced(values, rows, values[rows] * np.minimum(level / safe, 1.0)[:, None])


def _cluster(
    values: FloatArray, theta_i: FloatArray, count: int, rng: np.random.Generator
) -> Contaminated:
    # Neighbours in incidence angle, ties in random order: a window of exactly `count`.
    shuffled = rng.permutation(len(values))
    order = shuffled[np.argsort(theta_i[shuffled], kind="stable")]
    first = int(rng.integers(0, len(values) - count + 1))
    rows = order[first : first + count]
    # One factor for the run, and one that is seen: at least a factor of two off.
    size = _log_uniform(2.0, FACTOR, 1, rng)[0]
    factor = size if rng.random() < 0.5 else 1.0 / size
    return _replaced(values, rows, values[rows] * factor)


OUTLIER_MODELS: dict[str, OutlierModel] = {
    "factor": _factor,
    "uniform": _uniform,
    "permute": _permute,
    "shadow": _shadow,
    "saturate": _saturate,
    "cluster": _cluster,
}
"""Every outlier model by its name."""

DEFAULT_OUTLIERS = "factor"
"""The model that benchmarks use unless told otherwise."""


def _random_rows(n: int, count: int, rng: np.random.Generator) -> IntArray:
    return rng.permutation(n)[:count]


def _log_uniform(low: float, high: float, count: int, rng: np.random.Generator) -> FloatArray:
    return np.exp(rng.uniform(np.log(low), np.log(high), count))


def _replaced(values: FloatArray, rows: IntArray, wrong: FloatArray) -> Contaminated:
    spoilt = values.copy()
    spoilt[rows] = wrong
    mask = np.zeros(len(values), dtype=bool)
    mask[rows] = True
    return Contaminated(spoilt, mask)
