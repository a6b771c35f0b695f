"""Weight functions and the median absolute deviation."""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["cauchy", "mad", "relative_exponential"]

# Makes the median absolute deviation estimate the standard deviation of a normal sample.
_NORMAL = 1.4826


def relative_exponential(deviation: FloatArray, gamma: float) -> FloatArray:
    """Return exp(-gamma d) of relative deviations d = |rho_i - rho~_i| / rho~_i >= 0.

    The weight of the correction-function method (poster, step "detect outliers").
    """
    return np.asarray(np.exp(-gamma * deviation))


def cauchy(residual: FloatArray, scale: float) -> FloatArray:
    """Return 1 / (1 + (r / scale)^2): the Cauchy (Lorentzian) weight, softly redescending."""
    return np.asarray(1.0 / (1.0 + (residual / scale) ** 2))


def mad(residual: FloatArray, center: float | None = None) -> float:
    """Return 1.4826 times the median of |r - center|; center None means the median.

    NaN are left out; 0.0 where nothing is left.
    """
    values = np.asarray(residual, dtype=np.float64)
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 0.0
    middle = np.median(values) if center is None else center
    return float(_NORMAL * np.median(np.abs(values - middle)))
