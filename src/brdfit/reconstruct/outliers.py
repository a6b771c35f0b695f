"""Which samples are named outliers, once a method has settled.

The weights of a robust fit fall smoothly; a list needs a line. A sample is named when its
residual, pooled over channels, is beyond `SCALES` robust standard deviations *and* beyond
`SMALLEST` in ln f_r. The first keeps a noisy instrument from being all outliers, the second
a nearly perfect fit from naming rounding errors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.robust import mad

__all__ = ["SCALES", "SMALLEST", "Outliers", "find_outliers"]

SCALES = 4.0
"""Multiples of the robust standard deviation of the pooled residuals."""
SMALLEST = float(np.log(1.3))
"""ln units: no sample within 30 % of the result is called wrong."""


@dataclass(frozen=True, eq=False)
class Outliers:
    """`rows` (n,) True where a sample is named, and the rule in words."""

    rows: BoolArray
    rule: str


def find_outliers(residuals: FloatArray, usable: BoolArray, per_channel: bool) -> Outliers:
    """Name the outliers among residuals (n, c) of ln f_r, NaN where there is none.

    The pooled size of a residual is its root mean square over the usable channels; with
    `per_channel` the largest channel, each against its own scale, decides.
    """
    known = usable & np.isfinite(residuals)
    size = np.abs(np.where(known, residuals, 0.0))
    if per_channel:
        scales = np.array([mad(residuals[known[:, c], c], 0.0) for c in range(size.shape[1])])
        limits = np.maximum(SCALES * scales, SMALLEST)
        rows = np.asarray((known & (size > limits)).any(axis=1))
        return Outliers(rows, _rule(float(limits.min()), float(limits.max())))
    pooled = np.sqrt((size**2).sum(axis=1) / np.maximum(known.sum(axis=1), 1))
    limit = max(SCALES * mad(pooled[known.any(axis=1)], 0.0), SMALLEST)
    rows = np.asarray(known.any(axis=1) & (pooled > limit))
    return Outliers(rows, _rule(limit, limit))


def _rule(low: float, high: float) -> str:
    span = f"{low:.3f}" if low == high else f"{low:.3f} to {high:.3f}"
    return (
        f"|ln(value / result)| above {span}: {SCALES:g} robust standard deviations, "
        f"at least {SMALLEST:.3f}"
    )
