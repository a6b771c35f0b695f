"""The cube-root cosine-weighted root mean square of Fores, Ferwerda and Gu.

Reference: A. Fores, J. Ferwerda, J. Gu, "Toward a Perceptually Based Metric for BRDF Modeling",
Color and Imaging Conference 2012.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.metrics.entries import Entries, Score, weighted_mean

__all__ = ["cube_root_rms"]


def cube_root_rms(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    cos_theta_i: npt.ArrayLike,
    cos_theta_o: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
) -> Score:
    """Return sqrt(sum w cbrt(((t - r) cos theta_i)^2) / sum w).

    r, t: `reference`, `test`, f_r (n, channels) in 1/sr; w: `weights` (n,), solid angles or
    even. The cube root compresses the specular peak, roughly as the eye does. Entries
    where r or t is missing or negative are skipped and counted. Symmetric in r and t.
    """
    entries = Entries.of(reference, test, cos_theta_i, cos_theta_o, weights)
    delta = (entries.test - entries.reference) * entries.cos_theta_i
    return entries.score(np.sqrt(weighted_mean(np.cbrt(delta**2), entries.weights)))
