"""Least squares, Gaussian coefficients, kriging, splines on a lattice. Knows nothing of BRDFs."""

from __future__ import annotations

from brdfit.linalg.definite import inverse_by_halves, solved, sweep_if_compiled
from brdfit.linalg.gaussian import CoefficientPosterior, LeftOut
from brdfit.linalg.kriging import CovariancePosterior
from brdfit.linalg.lattice import Lattice, node_positions
from brdfit.linalg.neighbours import Kriged, Neighbours
from brdfit.linalg.normal_equations import (
    NormalEquations,
    RidgeFit,
    nonnegative,
    ridge,
    ridge_with_intercept,
)
from brdfit.linalg.packed import Triangle
from brdfit.linalg.tall import forward
from brdfit.linalg.thin import thin_product
from brdfit.linalg.threads import one_thread, side_by_side

__all__ = [
    "CoefficientPosterior",
    "CovariancePosterior",
    "Kriged",
    "Lattice",
    "LeftOut",
    "Neighbours",
    "NormalEquations",
    "RidgeFit",
    "Triangle",
    "forward",
    "inverse_by_halves",
    "node_positions",
    "nonnegative",
    "one_thread",
    "ridge",
    "ridge_with_intercept",
    "side_by_side",
    "solved",
    "sweep_if_compiled",
    "thin_product",
]
