"""Starts that outliers cannot own: members of the population, each up to a scale, and its mean.

Of every column, scaled to the samples, the mixture likelihood at a wide s is asked. The scales
that are tried put the column low, in the middle or high among the samples, and each of the
three has its own most likely columns: outliers that are bright together own the high starts,
and leave the low ones alone.
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.reconstruct.posterior.measurements import Measurements
from brdfit.reconstruct.posterior.refine import Belief
from brdfit.robust import Background, Mixture

__all__ = ["starting_beliefs"]

WIDE = 0.25
"""s at which starts are judged: how far a member of the same kind is from a material."""
_SHARE = 0.3
_QUANTILES = ((3.0, 8.0, 15.0), (30.0, 50.0, 70.0), (85.0, 92.0, 97.0))
# Rows that the columns are compared at: enough to tell materials apart.
_ROWS = 400
# ln f_r: a channel's own scale is sought this far from the column.
_REACH = 0.7


def starting_beliefs(data: Measurements, columns: FloatArray, count: int) -> list[Belief]:
    """Return the beliefs that about `count` columns, and the last, lead to.

    `columns` (n, k) are ln f_r of candidates at the samples; the last is the prior mean.
    """
    mixture = Mixture(_SHARE, Background.of(data.y, data.known))
    some = data.spread_out(_ROWS)
    difference = _level(data)[some, None] - columns[some]
    each = max(1, count // len(_QUANTILES))
    found = []
    for quantiles in _QUANTILES:
        shift, score = _best_shifts(difference, quantiles, mixture)
        best = np.argsort(-score, kind="stable")[:each]
        found += [_belief(data, columns[:, index] + shift[index], mixture) for index in best]
    shift, _ = _best_shifts(difference[:, -1:], sum(_QUANTILES, ()), mixture)
    return [*found, _belief(data, columns[:, -1] + shift[0], mixture)]


def _belief(data: Measurements, column: FloatArray, mixture: Mixture) -> Belief:
    """Judge by a scaled column (n,), each channel shifted to where most of the near ones are."""
    difference = data.y - column[:, None]
    near = data.known & (np.abs(difference - _centre(data, difference)) < _REACH)
    shift = np.array(
        [np.median(d[k]) if k.any() else 0.0 for d, k in zip(difference.T, near.T, strict=True)]
    )
    mean = column[:, None] + shift
    known = data.informative(mean)
    verdict = mixture.judge(data.y, mean, WIDE**2 + data.scatter, known)
    return Belief(
        verdict.responsibility, WIDE, mixture.updated(data.y, verdict, known), verdict.credit
    )


def _centre(data: Measurements, difference: FloatArray) -> FloatArray:
    """Return the median offset of each channel (c,) over rows whose mean is near the column."""
    close = np.abs(np.where(data.known, difference, 0.0).sum(axis=1)) < _REACH * data.known.sum(1)
    rows = data.known & close[:, None]
    return np.array(
        [np.median(d[k]) if k.any() else 0.0 for d, k in zip(difference.T, rows.T, strict=True)]
    )


def _level(data: Measurements) -> FloatArray:
    """Return the mean of ln f_r over the known channels (n,)."""
    return np.asarray(np.where(data.known, data.y, 0.0).sum(axis=1) / data.known.sum(axis=1))


def _best_shifts(
    difference: FloatArray, quantiles: tuple[float, ...], mixture: Mixture
) -> tuple[FloatArray, FloatArray]:
    """Return (shift, score), each (k,), of differences (n, k): the likeliest scale of each."""
    best = np.full(difference.shape[1], -np.inf)
    shift = np.zeros(difference.shape[1])
    # a background that is flat over the range of differences
    flat = mixture.share / (4.0 * mixture.background.breadth)
    for candidate in np.percentile(difference, quantiles, axis=0):
        z = (difference - candidate) / WIDE
        right = (1.0 - mixture.share) / (WIDE * np.sqrt(2.0 * np.pi)) * np.exp(-0.5 * z * z)
        score = np.log(right + flat).sum(axis=0)
        better = score > best
        best[better], shift[better] = score[better], candidate[better]
    return shift, best
