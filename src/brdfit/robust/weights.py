"""Weight functions and a scale that withstands a majority of wild values."""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["cauchy", "quartile_scale", "relative_exponential"]

# A quarter of a standard normal sample is within this of zero.
_NORMAL_QUARTILE = 0.318639


def relative_exponential(deviation: FloatArray, gamma: float) -> FloatArray:
    """Return exp(-gamma d) of relative deviations d = |rho_i - rho~_i| / rho~_i >= 0.

    The weight of the correction-function method (poster, step "detect outliers").
    """
    return np.asarray(np.exp(-gamma * deviation))


def cauchy(residual: FloatArray, scale: float) -> FloatArray:
    """Return 1 / (1 + (r / scale)^2): the Cauchy (Lorentzian) weight, softly redescending."""
    return np.asarray(1.0 / (1.0 + (residual / scale) ** 2))


def quartile_scale(size: FloatArray) -> float:
    """Return the standard deviation of a normal sample of which `size` holds |r|, (n,).

    From the 25th percentile, which up to three quarters of wild values cannot send to
    infinity: the median absolute deviation bears no more than half. 0.0 for an empty sample.
    """
    return float(np.percentile(size, 25.0) / _NORMAL_QUARTILE) if size.size else 0.0
