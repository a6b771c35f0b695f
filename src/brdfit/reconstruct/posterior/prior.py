"""What a population says beforehand: a Gaussian over the components of ln f_r.

With the coordinates V_j of the columns and weights omega_j that sum to one,

    m = sum_j omega_j V_j,     S = sum_j omega_j (V_j - m)(V_j - m)^T = G G^T

    ln f_r(x) = mu(x) + B(x) (m + G z) + tau z_0,     z ~ N(0, I)

tau z_0 is the brightness: a scale that no population knows. Columns that are *close* to a
first estimate can be given more weight (`closer`): a material is more like some than others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["BRIGHTNESS", "PopulationPrior", "closer", "population_prior"]

BRIGHTNESS = 2.0
"""tau: standard deviation of the unknown scale, in ln f_r."""
# Directions of the prior below this share of the largest variance are left out.
_SMALLEST = 1e-7


@dataclass(frozen=True, eq=False)
class PopulationPrior:
    """m (q,) and G (q, r), the most variable direction first."""

    mean: FloatArray
    factor: FloatArray

    @property
    def size(self) -> int:
        """Number of coefficients: r and the brightness."""
        return int(self.factor.shape[1]) + 1

    def log_mean(self, components: FloatArray) -> FloatArray:
        """Return the prior mean of ln f_r (n,) from [mu | B] (n, 1 + q)."""
        return np.asarray(components[:, 0] + components[:, 1:] @ self.mean)

    def features(self, components: FloatArray) -> FloatArray:
        """Return [B G | tau] (n, r + 1), float64, from [mu | B]."""
        result = np.empty((len(components), self.size))
        np.matmul(components[:, 1:].astype(np.float64), self.factor, out=result[:, :-1])
        result[:, -1] = BRIGHTNESS
        return result

    def combination(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (w (1 + q, c), constant (c,)): ln f_r = [mu | B] w + constant."""
        components = self.mean[:, None] + self.factor @ coefficients[:-1]
        ones = np.ones((1, coefficients.shape[1]))
        return np.vstack([ones, components]), BRIGHTNESS * coefficients[-1]

    def leading(self, size: int) -> PopulationPrior:
        """Return the prior restricted to its `size` most variable directions."""
        return PopulationPrior(self.mean, self.factor[:, :size])


def population_prior(
    axes: FloatArray, weights: FloatArray, sizes: FloatArray | None = None
) -> PopulationPrior:
    """Return the prior of columns with coordinates `axes` (columns, q) and weights (columns,).

    `sizes` (q,) say how large a component is in ln f_r. They do not change the prior, only
    which of its directions come first: the coordinates themselves are all of one size.
    """
    weights = weights / weights.sum()
    mean = weights @ axes
    scale = np.ones(axes.shape[1]) if sizes is None else np.maximum(sizes, 1e-12)
    spread = (axes - mean) * scale * np.sqrt(weights)[:, None]
    values, vectors = np.linalg.eigh(spread.T @ spread)
    kept = values > max(_SMALLEST * values[-1], 1e-300)
    factor = vectors[:, kept] * np.sqrt(values[kept]) / scale[:, None]
    return PopulationPrior(mean, np.ascontiguousarray(factor[:, ::-1]))


def closer(
    weights: FloatArray, distances: FloatArray, nearest: int, reach: float, mix: float
) -> FloatArray:
    """Return column weights (columns,) that favour columns near a first estimate.

    `distances` (columns,) are mean squared differences; the `nearest`-th smallest among the
    columns in use sets the unit, `reach` of which a column may be away. A share `mix` of the
    weight stays as it was, so that nothing is ruled out.
    """
    used = weights > 0.0
    unit = np.sort(distances[used])[min(nearest, int(used.sum()) - 1)]
    favour = weights * np.exp(-0.5 * (distances - distances[used].min()) / (reach * unit + 1e-12))
    favour /= favour.sum()
    return np.asarray((1.0 - mix) * favour + mix * weights / weights.sum())
