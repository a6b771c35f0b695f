"""Where values lie that no prediction explains: as a smooth density of those found to be wrong.

    O(y) = (1 - t) (sum_ic w_i / C  N(y; y_ic, h^2)  +  m N(y; centre, breadth^2)) / (sum_i w_i + m)
           + t N(y; centre, 5^2)

with w_i how wrong row i is, C its number of channels, and m imagined values spread like all that
are known. How stray light, a clipped sensor or a mislabelled direction is distributed is
nobody's to assume: a normal in its place makes outliers unlikely that crowd together, and a fit
that takes the crowd for the material wins. h is 0.7 of what would be best were they normal,
those imagined among them.

Reference: B. W. Silverman, "Density Estimation for Statistics and Data Analysis", Chapman and
Hall 1986, section 3.4.2 (h = 1.06 sigma n^(-1/5)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray

__all__ = ["Background", "mean_known"]

# m, the least breadth of values, and t.
_IMAGINED, _NARROWEST, _FLOOR = 5.0, 0.7, 0.02
# Of the bandwidth that is best for a normal.
_SHARPER = 0.7 * 1.06
# ln f_r between the nodes of the density, and bandwidths to where it ends.
_STEP, _REACH = 0.05, 5.0


@dataclass(frozen=True, eq=False)
class Found:
    """sum_ic w_i / C N(y; y_ic, h^2) at nodes a `_STEP` apart, and sum_i w_i."""

    first: float
    density: FloatArray
    weight: float

    @classmethod
    def of(cls, values: FloatArray, weights: FloatArray, imagined: Background) -> Found:
        """Take values (k,) of weights (k,), w_i / C each; they add up to a number of rows.

        A few that are found side by side are no crowd yet: those imagined count in sigma and n.
        """
        total = float(weights.sum())
        mean = float(weights @ values + _IMAGINED * imagined.centre) / (total + _IMAGINED)
        spread = float(weights @ (values - mean) ** 2)
        spread += _IMAGINED * (imagined.breadth**2 + (imagined.centre - mean) ** 2)
        sigma = float(np.sqrt(spread / (total + _IMAGINED)))
        bandwidth = _SHARPER * sigma * (total + _IMAGINED) ** -0.2
        half = int(np.ceil(_REACH * bandwidth / _STEP))
        first = float(values.min()) - half * _STEP
        place = (values - first) / _STEP
        below = place.astype(np.int64)
        beyond = place - below
        size = int(below.max()) + half + 2
        counts = np.bincount(below, weights * (1.0 - beyond), size)
        counts += np.bincount(below + 1, weights * beyond, size)
        bell = normal(_STEP * np.arange(-half, half + 1), bandwidth)
        return cls(first, np.convolve(counts, bell, mode="same"), total)

    def at(self, y: FloatArray) -> FloatArray:
        """Return the sum at y, of its shape; 0 far from all values."""
        place = (y - self.first) / _STEP
        nodes = np.arange(self.density.size)
        return np.asarray(np.interp(place, nodes, self.density, left=0.0, right=0.0))


@dataclass(frozen=True, eq=False)
class Background:
    """A density over y: centre and breadth of what is imagined, and what was found."""

    centre: float
    breadth: float
    found: Found | None = None

    @classmethod
    def of(cls, y: FloatArray, known: BoolArray, wrong: FloatArray | None = None) -> Background:
        """Fit it to the known values of y (n, c), weighted by how `wrong` (n,) their rows are.

        The imagined ones keep it broad where hardly anything is wrong.
        """
        values = y[known]
        centre, breadth = float(np.median(values)), max(float(np.std(values)), _NARROWEST)
        if wrong is None:
            return cls(centre, breadth)
        weights = np.broadcast_to(wrong[:, None], y.shape)[known] / y.shape[1]
        imagined = cls(centre, breadth)
        return cls(centre, breadth, Found.of(values, weights, imagined))

    def log_density(self, y: FloatArray, known: BoolArray) -> FloatArray:
        """Return ln O_i (n,), the mean of ln O over the known entries of a row."""
        likely = normal(y - self.centre, self.breadth)
        if self.found is not None:
            likely = (self.found.at(y) + _IMAGINED * likely) / (self.found.weight + _IMAGINED)
        floor = _FLOOR * normal(y - self.centre, 5.0)
        return mean_known(np.log((1.0 - _FLOOR) * likely + floor), known)


def normal(x: FloatArray, width: float) -> FloatArray:
    """Return N(x; 0, width^2), never quite zero."""
    return np.asarray(np.exp(-0.5 * (x / width) ** 2) / (width * np.sqrt(2.0 * np.pi)) + 1e-30)


def mean_known(values: FloatArray, known: BoolArray) -> FloatArray:
    """Return the mean of values (n, c) over the known entries of each row, 0 where none is."""
    count = np.maximum(known.sum(axis=1), 1)
    return np.asarray(np.where(known, values, 0.0).sum(axis=1) / count)
