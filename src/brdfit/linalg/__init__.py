"""Small least-squares problems given by their normal equations. Knows nothing of BRDFs."""

from __future__ import annotations

from brdfit.linalg.normal_equations import (
    NormalEquations,
    RidgeFit,
    nonnegative,
    ridge,
    ridge_with_intercept,
)

__all__ = ["NormalEquations", "RidgeFit", "nonnegative", "ridge", "ridge_with_intercept"]
