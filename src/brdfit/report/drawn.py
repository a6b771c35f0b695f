"""What can be drawn beside a table: its samples and its uncertainty, in the table's channels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.render import to_rgb
from brdfit.report.fitted import Fitted
from brdfit.report.slice_panel import Stddev
from brdfit.samples import Samples

__all__ = ["drawn_samples", "stddev_of"]


def drawn_samples(fitted: Fitted) -> tuple[Samples | None, BoolArray | None]:
    """Return the samples in the channels of the table, and which are outliers.

    Bands become linear sRGB where the table is in it; None where the channels of the two
    have nothing to do with each other.
    """
    if fitted.judged is None:
        return None, None
    samples, table = fitted.judged.samples, fitted.table
    if samples.n_channels != table.n_channels:
        if table.n_channels != 3:
            return None, None
        rgb = to_rgb(samples.value, samples.wavelengths, samples.channels)
        samples = replace(samples, value=rgb, sigma=None, wavelengths=None, channels=table.channels)
    return samples, fitted.judged.outliers


def stddev_of(fitted: Fitted) -> Stddev | None:
    """Return the standard deviation of ln f_r in the channels of the table, if it is stated."""
    stated = fitted.uncertainty
    if stated is None:
        return None
    if stated.stddev.n_channels in (1, fitted.table.n_channels):
        return stated.evaluate

    def common(wi: FloatArray, wo: FloatArray) -> FloatArray:
        # of other channels than the table's: what they have in common
        return np.asarray(np.sqrt(np.mean(stated.evaluate(wi, wo) ** 2, axis=1, keepdims=True)))

    return common
