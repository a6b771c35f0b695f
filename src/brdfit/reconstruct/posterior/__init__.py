"""`Posterior`: a Gaussian process on ln f_r whose prior is a population and a local residual.

    ln f_r(x) = mu(x) + B(x) (m + G z) + tau z_0 + e(x) + q(x),     z ~ N(0, I),     e ~ GP(0, k)

`principal` and `prior` say what a population of materials has in common, `kernel` lets a
material leave it where the data insist, along the lobe of its `section`, and `choice` finds the
kernel; `systems` make one linear system of both, `stages` and `refine` find who is to be
believed, `detail` and `judging` what many samples say beyond that (q), `calibration` how far to
trust what is stated. A direction pair and its reciprocal are one place, and f_r is an
exponential: reciprocity and positivity hold by construction.
"""

from __future__ import annotations

from brdfit.reconstruct.posterior.method import Posterior

__all__ = ["Posterior"]
