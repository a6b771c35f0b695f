"""Which samples are named outliers once a method has settled, and what that says of the fit.

The weights of a robust fit fall smoothly; a list needs a line. A sample is named when its
residual, pooled over channels, is beyond `SCALES` robust standard deviations *and* beyond
`SMALLEST` in ln f_r. The first keeps a noisy instrument from being all outliers, the second
a nearly perfect fit from naming rounding errors. The standard deviation is taken from the
smallest quarter of the residuals, so that outliers can be named where they are the majority.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.targets import pooled
from brdfit.robust import quartile_scale

__all__ = ["FEWEST", "SCALES", "SMALLEST", "Outliers", "find_outliers"]

SCALES = 4.0
"""Multiples of the robust standard deviation of the pooled residuals."""
SMALLEST = float(np.log(1.3))
"""ln units: no sample within 30 % of the result is called wrong."""
FEWEST = 8
"""With fewer usable samples than this, most of any result is assumed, not measured."""
# ln units: a sample that is off by a factor of two disagrees, however wide the scatter is.
_DISAGREES = float(np.log(2.0))


@dataclass(frozen=True, eq=False)
class Outliers:
    """Which samples are named, why, and how many disagree."""

    rows: BoolArray
    """(n,) True where a sample is named."""
    rule: str
    """The rule in words, with its figures."""
    usable: int
    """Number of usable samples."""
    disagreeing: int
    """Those that are named, or off by more than a factor of two on average over channels."""

    def outcome(self, ending: Outcome) -> Outcome:
        """Return what the samples say of the fit, or else `ending`: how the method ended."""
        if self.usable < FEWEST:
            return Outcome.TOO_FEW_SAMPLES
        if 2 * self.disagreeing > self.usable:
            return Outcome.MOSTLY_OUTLIERS
        return ending


def find_outliers(residuals: FloatArray, usable: BoolArray, per_channel: bool) -> Outliers:
    """Name the outliers among residuals (n, c) of ln f_r, NaN where there is none.

    The pooled size of a residual is its mean over the usable channels; with `per_channel`
    each channel is judged against its own scale, and one that is beyond it is enough.
    """
    known = usable & np.isfinite(residuals)
    mean_size = pooled(np.abs(residuals), known, per_channel=False).max(axis=1, keepdims=True)
    size = np.abs(residuals) if per_channel else mean_size
    judged = known if per_channel else np.asarray(known.any(axis=1, keepdims=True))
    scales = [quartile_scale(size[judged[:, c], c]) for c in range(size.shape[1])]
    limits = np.maximum(SCALES * np.array(scales), SMALLEST)
    with np.errstate(invalid="ignore"):
        rows = np.asarray((judged & (size > limits)).any(axis=1))
    disagreeing = rows | (mean_size[:, 0] > _DISAGREES)
    return Outliers(
        rows,
        _rule(float(limits.min()), float(limits.max())),
        usable=int(usable.any(axis=1).sum()),
        disagreeing=int(disagreeing.sum()),
    )


def _rule(low: float, high: float) -> str:
    span = f"{low:.3f}" if low == high else f"{low:.3f} to {high:.3f}"
    return (
        f"mean |ln(value / result)| above {span}: {SCALES:g} robust standard deviations, "
        f"at least {SMALLEST:.3f}"
    )
