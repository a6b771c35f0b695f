"""Small least-squares problems: normal equations, Gaussian coefficients. Knows nothing of BRDFs."""

from __future__ import annotations

from brdfit.linalg.definite import inverse_by_halves, inverses, sweep_if_compiled
from brdfit.linalg.gaussian import CoefficientPosterior, LeftOut
from brdfit.linalg.normal_equations import (
    NormalEquations,
    RidgeFit,
    nonnegative,
    ridge,
    ridge_with_intercept,
)
from brdfit.linalg.threads import one_thread

__all__ = [
    "CoefficientPosterior",
    "LeftOut",
    "NormalEquations",
    "RidgeFit",
    "inverse_by_halves",
    "inverses",
    "nonnegative",
    "one_thread",
    "ridge",
    "ridge_with_intercept",
    "sweep_if_compiled",
]
