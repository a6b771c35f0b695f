"""What every metric in BRDF space starts from: the entries that can be compared."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray, as_columns
from brdfit.errors import UsageError

__all__ = ["Entries", "Score", "weighted_mean"]


class Score(NamedTuple):
    """The value of a metric and on how much it rests; an entry is one direction and channel."""

    value: float
    """NaN if no entry could be compared."""
    used: int
    """Entries that were compared."""
    skipped: int
    """Entries left out: missing, negative, or (where logarithms are taken) zero."""


class Entries(NamedTuple):
    """Comparable entries, flattened over directions and channels, all (used,)."""

    reference: FloatArray
    test: FloatArray
    cos_theta_i: FloatArray
    cos_theta_o: FloatArray
    weights: FloatArray
    skipped: int

    @classmethod
    def of(
        cls,
        reference: npt.ArrayLike,
        test: npt.ArrayLike,
        cos_theta_i: npt.ArrayLike,
        cos_theta_o: npt.ArrayLike,
        weights: npt.ArrayLike | None = None,
        *,
        positive: bool = False,
    ) -> Entries:
        """Return the entries that can be compared.

        | name          | shape                | unit and range                          |
        |---------------|----------------------|-----------------------------------------|
        | `reference`   | (n, channels) or (n,) | f_r, 1/sr; NaN or negative = missing   |
        | `test`        | the same             | f_r, 1/sr; NaN or negative = missing    |
        | `cos_theta_i` | (n,)                 | of the light                            |
        | `cos_theta_o` | (n,)                 | of the detector                         |
        | `weights`     | (n,) or None         | >= 0, such as solid angles; None = even |

        With `positive`, zeros are left out too: they have no logarithm.
        """
        a = as_columns("reference", reference, len(np.asarray(reference)))
        b = as_columns("test", test, len(a))
        if a.shape != b.shape:
            raise UsageError(
                f"test: found {b.shape[1]} channels but the reference has {a.shape[1]}. Convert "
                f"both to the same channels first, brdfit.render.to_rgb makes three of any."
            )
        per_direction = [
            np.broadcast_to(_row(name, values, len(a))[:, None], a.shape)
            for name, values in (
                ("cos_theta_i", cos_theta_i),
                ("cos_theta_o", cos_theta_o),
                ("weights", np.ones(len(a)) if weights is None else weights),
            )
        ]
        with np.errstate(invalid="ignore"):
            usable = (a > 0.0) & (b > 0.0) if positive else (a >= 0.0) & (b >= 0.0)
        usable &= np.isfinite(a) & np.isfinite(b)
        cos_i, cos_o, weight = (values[usable] for values in per_direction)
        skipped = int(a.size - np.count_nonzero(usable))
        return cls(a[usable], b[usable], cos_i, cos_o, weight, skipped)

    def score(self, value: float) -> Score:
        """Return `value` with the counts of these entries."""
        return Score(float(value), int(self.reference.size), self.skipped)


def weighted_mean(value: FloatArray, weights: FloatArray) -> float:
    """Return sum(w x) / sum(w); NaN where nothing has weight."""
    total = float(np.sum(weights))
    return float(np.sum(weights * value)) / total if total > 0.0 else float("nan")


def _row(name: str, value: npt.ArrayLike, n: int) -> FloatArray:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (n,):
        raise UsageError(f"{name}: found shape {array.shape} but there are {n} directions.")
    return array
