"""The three error metrics of the published method: linear, root, logarithmic.

An error metric is the domain g in which values are combined and squared differences are
taken: g(f) = f, sqrt(f) or ln f. The poster names the three without defining them; `root`
is taken as the square root. Everything is written in terms of ln f, which every population
offers, so that no metric can overflow on the way.

Combining in the encoded domain, g(f) = sum_i alpha_i g(M_i), makes every least-squares
fit a matter of one Gram matrix. In the logarithmic domain a constant joins the members:
it is a scale factor, which the other two domains have by homogeneity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError

__all__ = ["ERROR_METRICS", "ErrorMetric", "error_metric"]

# ln of the smallest value a decoded combination may take: combinations of members may
# reach zero, whose logarithm nobody wants. The largest keeps a fit that runs away between
# its samples finite in single precision.
_LOG_SMALLEST, _LOG_LARGEST = float(np.log(1e-6)), float(np.log(1e12))


@dataclass(frozen=True)
class ErrorMetric:
    """g(f) = f^power, or ln f for power 0."""

    name: str
    power: float

    @property
    def needs_constant(self) -> bool:
        """True where a scale factor is an additive constant of the encoded domain."""
        return self.power == 0.0

    def encode(self, log_value: FloatArray) -> FloatArray:
        """Return g(f) of ln f, any shape."""
        if self.power == 0.0:
            return log_value
        return np.asarray(np.exp(self.power * log_value))

    def decode(self, encoded: FloatArray) -> FloatArray:
        """Return ln f of g(f), any shape, held between ln 1e-6 and ln 1e12."""
        if self.power == 0.0:
            return np.asarray(np.clip(encoded, _LOG_SMALLEST, _LOG_LARGEST))
        low, high = np.exp(self.power * np.array([_LOG_SMALLEST, _LOG_LARGEST]))
        return np.asarray(np.log(np.clip(encoded, float(low), float(high))) / self.power)


ERROR_METRICS = {
    "linear": ErrorMetric("linear", 1.0),
    "root": ErrorMetric("root", 0.5),
    "log": ErrorMetric("log", 0.0),
}
"""Name -> error metric."""


def error_metric(name: str) -> ErrorMetric:
    """Return the error metric of that name; `UsageError` lists the names there are."""
    if name not in ERROR_METRICS:
        raise UsageError(
            f"error_metric: found {name!r} but expected one of {', '.join(ERROR_METRICS)}."
        )
    return ERROR_METRICS[name]
