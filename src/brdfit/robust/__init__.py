"""Weights that tell how much a sample counts, and the scale they are measured by.

Knows nothing of BRDFs: arrays of residuals in, arrays of weights in [0, 1] out.
"""

from __future__ import annotations

from brdfit.robust.background import Background, mean_known
from brdfit.robust.mixture import Factors, Mixture, Verdict
from brdfit.robust.unevenness import Unevenness
from brdfit.robust.weights import cauchy, quartile_scale, relative_exponential

__all__ = [
    "Background",
    "Factors",
    "Mixture",
    "Unevenness",
    "Verdict",
    "cauchy",
    "mean_known",
    "quartile_scale",
    "relative_exponential",
]
