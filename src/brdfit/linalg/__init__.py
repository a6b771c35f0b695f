"""Small least-squares problems: normal equations, Gaussian coefficients. Knows nothing of BRDFs."""

from __future__ import annotations

from brdfit.linalg.gaussian import CoefficientPosterior, LeftOut
from brdfit.linalg.normal_equations import (
    NormalEquations,
    RidgeFit,
    nonnegative,
    ridge,
    ridge_with_intercept,
)

__all__ = [
    "CoefficientPosterior",
    "LeftOut",
    "NormalEquations",
    "RidgeFit",
    "nonnegative",
    "ridge",
    "ridge_with_intercept",
]
