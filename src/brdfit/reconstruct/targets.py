"""What a fit compares with: ln f_r of each measurement, or a bound where it is censored."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import SampleError
from brdfit.samples import Samples

__all__ = ["Targets", "pooled"]


@dataclass(frozen=True, eq=False)
class Targets:
    """ln f_r (n, c) of the measurements, with what is known of each.

    A censored measurement (zero or negative: the noise floor) stands at the ln of its
    channel's floor and says only that the truth is not above it.
    """

    log_value: FloatArray
    usable: BoolArray
    censored: BoolArray

    @classmethod
    def of(cls, samples: Samples) -> Targets:
        """Take the usable values of `samples`; the rest is NaN.

        Raises `SampleError` where a channel has no positive value: nothing says how bright
        it is.
        """
        positive = np.asarray(samples.positive.any(axis=0))
        dark = [name for c, name in enumerate(samples.channels) if not positive[c]]
        if dark:
            raise SampleError(
                f"{samples.source.name}: channel {', '.join(dark)} has no usable positive value, "
                f"so nothing says how bright it is. Leave it out (Samples.select_channels)."
            )
        floor = np.broadcast_to(samples.noise_floor, samples.value.shape)
        usable = samples.positive | (samples.censored & np.isfinite(floor))
        value = np.where(samples.positive, samples.value, floor)
        log_value = np.log(np.where(usable, value, 1.0))
        return cls(np.where(usable, log_value, np.nan), usable, usable & samples.censored)

    def take(self, rows: BoolArray | IntArray | slice) -> Targets:
        """Return the targets of some rows."""
        return Targets(self.log_value[rows], self.usable[rows], self.censored[rows])

    def informative(self, log_estimate: FloatArray) -> BoolArray:
        """(n, c): True where the measurement can say that the estimate is off.

        A bound that the estimate respects has nothing to say.
        """
        with np.errstate(invalid="ignore"):
            respected = self.censored & (log_estimate <= self.log_value)
        return np.asarray(self.usable & ~respected)

    def residual(self, log_estimate: FloatArray) -> FloatArray:
        """Return ln value - ln estimate (n, c); 0 for a respected bound, NaN if unusable."""
        difference = self.log_value - log_estimate
        respected = self.usable & ~self.informative(log_estimate)
        return np.asarray(np.where(respected, 0.0, difference))


def pooled(values: FloatArray, known: BoolArray, per_channel: bool) -> FloatArray:
    """Return the mean of `values` (n, c) over the known channels, repeated in each.

    A wrong measurement is wrong in all its channels. `per_channel` returns the values as
    they are. Unknown entries are 0.
    """
    held = np.where(known, values, 0.0)
    if per_channel:
        return held
    count = np.maximum(known.sum(axis=1, keepdims=True), 1)
    return np.where(known, held.sum(axis=1, keepdims=True) / count, 0.0)
