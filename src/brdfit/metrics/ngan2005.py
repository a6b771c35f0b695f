"""The cosine-weighted root mean square of Ngan, Durand and Matusik.

Reference: A. Ngan, F. Durand, W. Matusik, "Experimental Analysis of BRDF Models", Eurographics
Symposium on Rendering 2005.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.metrics.entries import Entries, Score, weighted_mean

__all__ = ["cosine_rms"]


def cosine_rms(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    cos_theta_i: npt.ArrayLike,
    cos_theta_o: npt.ArrayLike,
    weights: npt.ArrayLike | None = None,
) -> Score:
    """Return sqrt(sum w ((t - r) cos theta_i)^2 / sum w), 1/sr.

    r, t: `reference`, `test`, f_r (n, channels) in 1/sr; w: `weights` (n,), the solid angle
    of each direction pair: on the MERL grid even weights count the specular peak many
    times over (Sun, Jensen and Ramamoorthi 2018). Ruled by the brightest entries.
    Entries where r or t is missing or negative are skipped and counted. Symmetric in r
    and t, not in light and detector.
    """
    entries = Entries.of(reference, test, cos_theta_i, cos_theta_o, weights)
    delta = (entries.test - entries.reference) * entries.cos_theta_i
    return entries.score(np.sqrt(weighted_mean(delta**2, entries.weights)))
