"""The cube-root difference weighted by both cosines, of Sun, Jensen and Ramamoorthi.

Reference: T. Sun, H. W. Jensen, R. Ramamoorthi, "Connecting Measured BRDFs to Analytic BRDFs by
Data-Driven Diffuse-Specular Separation", ACM Transactions on Graphics 37(6), 2018.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.metrics.entries import Entries, Score, weighted_mean

__all__ = ["cube_root_cosine"]

_LEAST_COSINE = 1e-3


def cube_root_cosine(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    cos_theta_i: npt.ArrayLike,
    cos_theta_o: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
) -> Score:
    """Return sum w |(t - r) c|^(2/3) / sum w with c = max(cos theta_i cos theta_o, 0.001).

    r, t: `reference`, `test`, f_r (n, channels) in 1/sr; w: `weights` (n,), solid angles or
    even. The paper writes the sum; the mean is the same up to a constant and does not grow
    with n. Entries where r or t is missing or negative are skipped and counted.
    Symmetric in r and t, and in light and detector.
    """
    entries = Entries.of(reference, test, cos_theta_i, cos_theta_o, weights)
    c = np.maximum(entries.cos_theta_i * entries.cos_theta_o, _LEAST_COSINE)
    delta = np.cbrt(((entries.test - entries.reference) * c) ** 2)
    return entries.score(weighted_mean(delta, entries.weights))
