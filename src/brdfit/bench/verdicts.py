"""How well a list of outliers names the samples that were spoilt on purpose.

A planted outlier is *beyond* the noise if its deviation from the value it was made of, the
root mean square over channels of the difference of ln f_r, is more than three times the noise
of a good sample. A smaller one is no worse than a good sample, and nobody can name it.

    precision   named and planted / named
    recall      named, planted and beyond / planted and beyond
    flagged     named / all
"""

from __future__ import annotations

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.bench.ledger import Record, figure

__all__ = ["deviation", "judged"]

_BEYOND = 3.0


def deviation(clean: FloatArray, spoilt: FloatArray) -> FloatArray:
    """Return how far each sample was moved (n,), ln f_r, from values (n, c) of both.

    Over the channels in which both are above zero; 0 where there is none.
    """
    known = (clean > 0.0) & (spoilt > 0.0)
    ratio = np.divide(spoilt, clean, out=np.ones_like(clean), where=known)
    square = np.log(ratio) ** 2
    return np.asarray(np.sqrt(square.sum(axis=1) / np.maximum(known.sum(axis=1), 1)))


def judged(named: BoolArray, planted: BoolArray, moved: FloatArray, noise: float) -> Record:
    """Return the figures of a list `named` (n,) where `planted` (n,) were `moved` (n,).

    A figure whose denominator is zero is None, and so is precision where none was planted.
    """
    beyond = planted & (moved > _BEYOND * noise)
    return {
        "precision": _share(named & planted, named) if planted.any() else None,
        "recall": _share(named & beyond, beyond),
        "flagged": figure(float(named.mean())) if named.size else None,
        "planted_beyond": int(beyond.sum()),
        "noise": figure(noise),
    }


def _share(part: BoolArray, whole: BoolArray) -> float | None:
    count = int(whole.sum())
    return figure(int(part.sum()) / count) if count else None
