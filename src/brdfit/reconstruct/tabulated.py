"""`Tabulated`: scattered-data interpolation by radial basis functions, exact at the samples.

After Zickler et al. 2005 ("Reflectance Sharing"), who interpolate f_r with radial basis
functions over half/difference angles. Every measurement is represented as it is, noise and
outliers included; where nobody measured, the method knows nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import FitError, UsageError
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.linalg import one_thread
from brdfit.progress import Progress, silent
from brdfit.reconstruct.checks import check_count
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.reconstruct.result import Reconstruction, direct_result
from brdfit.samples import Samples

__all__ = ["RbfModel", "Tabulated", "half_diff_features"]

# Directions closer than this in feature space are one: an exact interpolant cannot pass
# through two values at the same place, so they are averaged.
_SAME_PLACE = 1e-7
_SMALLEST = 1e-6
_CHUNK = 65_536
_KERNELS = ("linear", "thin_plate_spline", "cubic")


@dataclass(frozen=True, eq=False)
class RbfModel:
    """SciPy's interpolant of f_r over `half_diff_features`, a channel at a time where needed."""

    interpolators: tuple[Any, ...]
    """One `scipy.interpolate.RBFInterpolator` for each group of channels."""
    groups: tuple[tuple[int, ...], ...]

    @cached_property
    def n_channels(self) -> int:
        """Number of channels."""
        return sum(len(group) for group in self.groups)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr; the interpolant is held above 1e-6."""
        return self._at(half_diff_features(*half_diff_from_directions(wi, wo)), lambda done: None)

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr; 0 below the horizon."""
        features = half_diff_features(*grid.half_diff(grid.cells))
        found = self._at(features, lambda done: progress("dense result", done, len(features)))
        return grid.spread(found)

    def stddev(self, wi: FloatArray, wo: FloatArray) -> None:
        """Return None: an exact interpolant knows no uncertainty."""
        return None

    def _at(self, features: FloatArray, step: Any) -> FloatArray:
        result = np.empty((len(features), self.n_channels))
        for start in range(0, len(features), _CHUNK):
            step(start)
            rows = slice(start, start + _CHUNK)
            for interpolator, group in zip(self.interpolators, self.groups, strict=True):
                try:
                    result[rows, list(group)] = interpolator(features[rows])
                except np.linalg.LinAlgError as error:
                    raise FitError(_FLAT.format(kernel=interpolator.kernel)) from error
        step(len(features))
        return np.maximum(result, _SMALLEST)


@dataclass(frozen=True)
class Tabulated:
    """Radial-basis-function interpolation of the samples, exact where they are."""

    name: ClassVar[str] = "tabulated"

    kernel: str = "linear"
    """Radial basis function: linear, thin_plate_spline or cubic."""
    neighbors: int = 64
    """Nearest samples that an interpolated value depends on (all of them, if there are fewer)."""

    def __post_init__(self) -> None:
        if self.kernel not in _KERNELS:
            raise UsageError(
                f"kernel: found {self.kernel!r} but expected one of {', '.join(_KERNELS)}."
            )
        check_count("neighbors", self.neighbors, 8)

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the interpolant of all usable values, zeros and negatives included.

        Samples of the same directions are averaged. Raises `SampleError` where none is usable,
        `FitError` where a kernel other than linear meets samples that lie in one plane.
        """
        samples.require_usable()
        features = half_diff_features(*half_diff_from_directions(*samples.safe_directions))
        interpolators, groups = [], []
        for group in _channel_groups(samples):
            rows = samples.usable[:, group[0]]
            interpolators.append(self.interpolator(features[rows], samples.value[rows][:, group]))
            groups.append(tuple(group))
        model = RbfModel(tuple(interpolators), tuple(groups))
        estimate = model.evaluate(*samples.safe_directions)
        return direct_result(self, samples, model, np.log(estimate))

    def interpolator(self, features: FloatArray, values: FloatArray) -> Any:
        """Return SciPy's interpolator through values (n, c) at features (n, 4)."""
        from scipy.interpolate import RBFInterpolator

        features, values = _merged(features, values)
        if len(features) < 6:  # too few for the linear polynomial in four coordinates
            return RBFInterpolator(features, values, kernel="linear", degree=0)
        degree = _DEGREE[self.kernel]
        if degree and _dimensions(features) < features.shape[1]:
            raise FitError(_FLAT.format(kernel=self.kernel))
        neighbors = None if len(features) <= self.neighbors else self.neighbors
        return RBFInterpolator(
            features, values, kernel=self.kernel, neighbors=neighbors, degree=degree
        )


# The lowest polynomial that makes the kernel's system solvable.
_DEGREE = {"linear": 0, "thin_plate_spline": 1, "cubic": 1}
_FLAT = (
    "kernel {kernel}: there are samples whose nearest neighbours lie in one plane of half/"
    "difference angles, as in measurements in the plane of incidence; this kernel cannot tell "
    "how the value changes out of that plane. Use kernel linear, or a method with a population."
)


def _dimensions(features: FloatArray) -> int:
    """Return how many directions `features` (n, 4) spread in by more than rounding."""
    spread = np.linalg.svd(features - features.mean(axis=0), compute_uv=False)
    return int((spread > _SAME_PLACE * np.sqrt(len(features))).sum())


def _channel_groups(samples: Samples) -> list[list[int]]:
    groups: dict[bytes, list[int]] = {}
    for channel in range(samples.n_channels):
        groups.setdefault(samples.usable[:, channel].tobytes(), []).append(channel)
    return list(groups.values())


def _merged(features: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    key = np.rint(features / _SAME_PLACE).astype(np.int64)
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    place = np.ravel(place)
    count = np.bincount(place)
    total = np.stack([np.bincount(place, weights=column) for column in values.T], axis=1)
    return features[first], total / count[:, None]
