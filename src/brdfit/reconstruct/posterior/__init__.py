"""`Posterior`: a Gaussian process on ln f_r whose prior is a population and a local residual.

    ln f_r(x) = mu(x) + B(x) (m + G z) + tau z_0 + a sum_k psi_k(x) z_k,     z ~ N(0, I)

`principal` and `prior` say what a population of materials has in common, `residual` lets a
material leave it where the data insist, `stages` find who is to be believed. Every direction
pair and its reciprocal have the same features, and f_r is an exponential: reciprocity and
positivity hold by construction.
"""

from __future__ import annotations

from brdfit.reconstruct.posterior.method import Posterior

__all__ = ["Posterior"]
