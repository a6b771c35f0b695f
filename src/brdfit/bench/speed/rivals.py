"""The same job by well-kept libraries, as their users would do it.

Interpolation of ln f_r over coordinates in which a BRDF is about equally smooth everywhere
(`half_diff_features`, those that the posterior's local residual has). None of them knows of
materials or of outliers.
"""

from __future__ import annotations

import warnings

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import MissingExtra
from brdfit.grid import Grid
from brdfit.reconstruct.compact import LeadingBasis
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.samples import Samples

__all__ = ["gaussian_process", "radial_basis", "ridge_loop"]

_CHUNK = 8192
# Variance of ln f_r of a sample, outliers among them; of white noise, to begin with.
_ETA = 0.05
_WHITE = 1e-2


def radial_basis(samples: Samples, grid: Grid) -> FloatArray:
    """Return f_r (cells, c) by SciPy's `RBFInterpolator`, thin plates, smoothing 0.001."""
    from scipy.interpolate import RBFInterpolator

    fitted = RBFInterpolator(
        half_diff_features(*samples.half_diff), np.log(samples.value), smoothing=1e-3
    )
    return _at_cells(fitted, grid)


def gaussian_process(samples: Samples, grid: Grid) -> FloatArray:
    """Return f_r (cells, c) by scikit-learn's `GaussianProcessRegressor`.

    A Matern kernel of smoothness 3/2 with a length along each coordinate, an amplitude and
    white noise, all of them optimised from where scikit-learn starts. Raises `MissingExtra`
    where it is not installed.
    """
    try:
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel
    except ImportError as error:
        raise MissingExtra("scikit-learn", "rivals", "the rival `sklearn_gp`") from error

    kernel = ConstantKernel() * Matern(length_scale=np.ones(4), nu=1.5) + WhiteKernel(_WHITE)
    process = GaussianProcessRegressor(kernel, normalize_y=True)
    with warnings.catch_warnings():
        # A bound that a length runs into is no reason to stop: its user would go on, too.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(half_diff_features(*samples.half_diff), np.log(samples.value))
    return _at_cells(process.predict, grid)


def ridge_loop(items: list[Samples], basis: LeadingBasis) -> FloatArray:
    """Return the coefficients (items, 1 + k, c) of items one by one: least squares and a ridge.

    The components are those of `Compact`, scaled so that their coefficients have variance 1:
    the ridge is the variance of ln f_r of a sample. All samples count alike.
    """
    found = []
    for item in items:
        mean, phi = basis.at(item.wi, item.wo)
        gram = phi.T @ phi
        gram[np.diag_indices_from(gram)] += _ETA
        found.append(np.linalg.solve(gram, phi.T @ (np.log(item.value) - mean[:, None])))
    return np.stack(found)


def _at_cells(predict: object, grid: Grid) -> FloatArray:
    assert callable(predict)
    parts = []
    for start in range(0, grid.cells.size, _CHUNK):
        angles = grid.half_diff(grid.cells[start : start + _CHUNK])
        parts.append(np.exp(predict(half_diff_features(*angles))).astype(np.float32))
    return np.concatenate(parts)
