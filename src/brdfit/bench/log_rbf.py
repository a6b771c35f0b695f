"""The rival that knows nothing of materials: radial basis functions through ln f_r.

SciPy's `RBFInterpolator` on the logarithm of positive values, in coordinates where a BRDF is
about equally smooth everywhere and reciprocity holds by construction:

    x = (scale sqrt(theta_h / (pi/2)), theta_d / (pi/2), r cos 2 phi_d, r sin 2 phi_d),
    r = sin theta_h sin theta_d         (at both poles phi_d has no meaning: r = 0)

Kernel, smoothing and scale are chosen by five-fold cross-validation inside the samples that
it is fitted to, never on those that it is judged by. That makes it a strong rival: it is
tuned to each file.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import FitError
from brdfit.geometry import half_diff_from_directions
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.samples import Samples

__all__ = ["LogRbf", "RbfSettings"]

_KERNELS = ("linear", "thin_plate_spline")
_SMOOTHINGS = (0.0, 1e-3, 1e-2, 1e-1)
_SCALES = (1.0, 3.0)
_FOLDS = 5
_SAME_PLACE = 1e-6
_DENSE_LIMIT = 3000
_NEIGHBORS = 100

Angles = tuple[FloatArray, FloatArray, FloatArray]
Predict = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class RbfSettings:
    """What the cross-validation chose for one group of channels."""

    kernel: str
    smoothing: float
    scale: float

    def __str__(self) -> str:
        return f"{self.kernel}, smoothing {self.smoothing:g}, theta_h x {self.scale:g}"


@dataclass(frozen=True, eq=False)
class LogRbf:
    """An interpolant of ln f_r per group of channels that are positive at the same samples."""

    groups: tuple[tuple[IntArray, RbfSettings, Predict], ...]
    n_channels: int

    @classmethod
    def fit(cls, samples: Samples, seed: int = 0) -> LogRbf:
        """Return the interpolant of the positive values of `samples`.

        Above 3000 samples each prediction uses the nearest 100 only. A channel that is
        nowhere positive predicts NaN.
        """
        groups = []
        for channels in _channel_groups(samples.positive):
            rows = samples.positive[:, channels[0]]
            if not rows.any():
                continue
            angles = _at(samples.half_diff, rows)
            log_value = np.log(samples.value[np.ix_(rows, channels)])
            settings = _choose(angles, log_value, seed)
            groups.append((channels, settings, _interpolant(angles, log_value, settings)))
        return cls(tuple(groups), samples.n_channels)

    @property
    def settings(self) -> str:
        """What was chosen, in words, each once."""
        return "; ".join(dict.fromkeys(str(settings) for _, settings, _ in self.groups))

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels), 1/sr, at direction pairs (n, 3)."""
        angles = half_diff_from_directions(wi, wo)
        result = np.full((len(wi), self.n_channels), np.nan)
        for channels, settings, predict in self.groups:
            result[:, channels] = np.exp(predict(_features(angles, settings.scale)))
        return result


def _features(angles: Angles, scale: float) -> FloatArray:
    return half_diff_features(*angles) * [scale, 1.0, 1.0, 1.0]


def _at(angles: Angles, rows: BoolArray) -> Angles:
    theta_h, theta_d, phi_d = angles
    return theta_h[rows], theta_d[rows], phi_d[rows]


def _channel_groups(positive: BoolArray) -> list[IntArray]:
    _, group = np.unique(positive, axis=1, return_inverse=True)
    group = np.ravel(group)
    return [np.flatnonzero(group == index) for index in range(int(group.max()) + 1)]


def _choose(angles: Angles, log_value: FloatArray, seed: int) -> RbfSettings:
    options = [RbfSettings(*option) for option in itertools.product(_KERNELS, _SMOOTHINGS, _SCALES)]
    n = len(log_value)
    if n < 2 * _FOLDS:
        return options[0]
    fold = np.random.default_rng([seed, n]).permutation(n) % _FOLDS
    errors = [_cross_validated(option, angles, log_value, fold) for option in options]
    return options[int(np.argmin(errors))]


def _cross_validated(
    settings: RbfSettings, angles: Angles, log_value: FloatArray, fold: IntArray
) -> float:
    total = 0.0
    for index in range(_FOLDS):
        aside = fold == index
        try:
            predict = _interpolant(_at(angles, ~aside), log_value[~aside], settings)
        except FitError:
            return np.inf
        predicted = predict(_features(_at(angles, aside), settings.scale))
        total += float(np.abs(predicted - log_value[aside]).sum())
    return total if np.isfinite(total) else np.inf


def _interpolant(angles: Angles, log_value: FloatArray, settings: RbfSettings) -> Predict:
    from scipy.interpolate import RBFInterpolator

    features = _features(angles, settings.scale)
    # Plane data leave a coordinate constant, which a polynomial part cannot bear.
    varies = np.ptp(features, axis=0) > _SAME_PLACE
    place, value = _merged(features[:, varies], log_value)
    if len(place) <= varies.sum() + 1:
        mean = value.mean(axis=0)
        return lambda points: np.broadcast_to(mean, (len(points), mean.size))
    try:
        fitted = RBFInterpolator(
            place,
            value,
            kernel=settings.kernel,
            smoothing=settings.smoothing,
            neighbors=_NEIGHBORS if len(place) > _DENSE_LIMIT else None,
        )
    except np.linalg.LinAlgError as error:
        raise FitError(f"log-domain RBF ({settings}): {error}.") from error
    return lambda points: np.asarray(fitted(points[:, varies]))


def _merged(place: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Average what was measured at the same place, which no interpolant can pass through."""
    key = np.rint(place / _SAME_PLACE).astype(np.int64)
    _, first, group = np.unique(key, axis=0, return_index=True, return_inverse=True)
    group = np.ravel(group)
    total = np.zeros((len(first), value.shape[1]))
    np.add.at(total, group, value)
    return place[first], total / np.bincount(group)[:, None]
