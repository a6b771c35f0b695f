"""Analytic BRDFs, vectorised over directions: synthetic truth, and the published fits.

Every model is a frozen dataclass of parameters with `evaluate(wi, wo) -> (n, channels)`
in 1/sr, cosine not included, 0 below the horizon. One published model, one module.
"""

from __future__ import annotations
