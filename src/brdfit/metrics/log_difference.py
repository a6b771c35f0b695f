"""Differences of the logarithm: relative errors, dark directions counting as much as bright.

The root mean square is the usual figure of merit of fits in a logarithmic domain (J. Loew,
J. Kronander, A. Ynnerman, J. Unger, "BRDF Models for Accurate and Efficient Rendering of
Glossy Surfaces", ACM Transactions on Graphics 31(1), 2012, fit ln(1 + f cos theta_i); here the
plain logarithm, so that the scale of f plays no role). It agrees poorly with what people see.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.metrics.entries import Entries, Score, weighted_mean

__all__ = ["log_rms", "mean_abs_log"]


def log_rms(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    cos_theta_i: npt.ArrayLike,
    cos_theta_o: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
) -> Score:
    """Return sqrt(sum w (ln t - ln r)^2 / sum w); 0.1 is about 10 %.

    r, t: `reference`, `test`, f_r (n, channels) in 1/sr; w: `weights` (n,). The cosines
    (n,) are taken for the sake of one signature and not used. Entries where r or t is
    missing or not above zero are skipped and counted. Symmetric in r and t.
    """
    entries = Entries.of(reference, test, cos_theta_i, cos_theta_o, weights, positive=True)
    delta = np.log(entries.test) - np.log(entries.reference)
    return entries.score(np.sqrt(weighted_mean(delta**2, entries.weights)))


def mean_abs_log(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    cos_theta_i: npt.ArrayLike,
    cos_theta_o: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
) -> Score:
    """Return sum w |ln t - ln r| / sum w, the mean |delta ln f|; 0.1 is about 10 %.

    As `log_rms`, less swayed by a few bad entries.
    """
    entries = Entries.of(reference, test, cos_theta_i, cos_theta_o, weights, positive=True)
    delta = np.log(entries.test) - np.log(entries.reference)
    return entries.score(weighted_mean(np.abs(delta), entries.weights))
