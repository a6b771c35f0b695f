"""`LocalBasis`: compactly supported splines over half/difference angles, smoothed.

    g(rho(theta_h, theta_d, phi_d)) = sum_abc q_abc B_a(u) B_b(v) P_c(w)

with cubic B-splines B over u = sqrt(theta_h / (pi/2)) and v = theta_d / (pi/2), periodic ones
P over w = phi_d / pi, and g the error metric's encoding. The coefficients minimise the mean
square error at the samples plus `smoothing` times the mean square second difference along
each axis. After Lawrence et al. 2006 ("Inverse Shade Trees") and Weistroffer et al. 2007
("Efficient Basis Decomposition for Scattered Reflectance Data"), who use other compactly
supported functions in the same role.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import scipy  # its parts are imported when they are first used

from brdfit.arrays import BoolArray, FloatArray
from brdfit.geometry import half_diff_from_directions, wrap_phi_d
from brdfit.grid import Grid
from brdfit.linalg import one_thread
from brdfit.progress import Progress, silent
from brdfit.reconstruct.checks import check_above, check_count
from brdfit.reconstruct.combination import equal_columns
from brdfit.reconstruct.result import Reconstruction, direct_result
from brdfit.reconstruct.targets import Targets
from brdfit.samples import Samples
from brdfit.transform import ErrorMetric, error_metric

__all__ = ["LocalBasis", "SplineModel", "SplineSpace"]

_DEGREE = 3
# Draws coefficients that no sample and no difference determines to the mean of the data.
_ANCHOR = 1e-8


@dataclass(frozen=True)
class SplineSpace:
    """Tensor-product splines of (n_theta_h, n_theta_d, n_phi_d) coefficients."""

    shape: tuple[int, int, int]

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return int(np.prod(self.shape))

    def factors(
        self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
    ) -> tuple[Any, Any, Any]:
        """Return the sparse design matrices of the three axes, (n_i, shape_i) each."""
        u = np.clip(np.sqrt(theta_h / (np.pi / 2)), 0.0, 1.0)
        v = np.clip(theta_d / (np.pi / 2), 0.0, 1.0)
        w = wrap_phi_d(phi_d) / np.pi
        return _clamped(u, self.shape[0]), _clamped(v, self.shape[1]), _periodic(w, self.shape[2])

    def design(self, theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray) -> Any:
        """Return the sparse design matrix (n, size) at n points."""
        a, b, c = self.factors(theta_h, theta_d, phi_d)
        return _row_product(_row_product(a, b), c)

    def penalty(self) -> FloatArray:
        """Return the matrix (size, size) whose quadratic form is the mean square difference."""
        eye = [np.eye(n) for n in self.shape]
        total = np.zeros((self.size, self.size))
        for axis, n in enumerate(self.shape):
            rough = [_roughness(n, periodic=axis == 2) if i == axis else eye[i] for i in range(3)]
            total += np.kron(np.kron(rough[0], rough[1]), rough[2])
        return total / self.size


def _clamped(x: FloatArray, n: int) -> Any:
    inner = np.linspace(0.0, 1.0, n - _DEGREE + 1)
    knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
    return scipy.interpolate.BSpline.design_matrix(x, knots, _DEGREE)


def _periodic(x: FloatArray, n: int) -> Any:
    knots = np.arange(-_DEGREE, n + _DEGREE + 1) / n
    wide = scipy.interpolate.BSpline.design_matrix(x, knots, _DEGREE)
    # The splines that stick out at the end are those that come in at the start. Renamed, not
    # multiplied out: a product would drop the zeros at the knots, and rows would differ in length.
    return scipy.sparse.csr_array(
        (wide.data, wide.indices % n, wide.indptr), shape=(wide.shape[0], n)
    )


def _row_product(a: Any, b: Any) -> Any:
    """Return the matrix whose row i is the Kronecker product of row i of a and of b."""
    left, right = scipy.sparse.csr_array(a), scipy.sparse.csr_array(b)
    rows = left.shape[0]
    # every row of a design has as many entries as every other
    k, m = (matrix.nnz // max(rows, 1) for matrix in (left, right))
    columns = (
        left.indices.reshape(rows, k, 1) * right.shape[1] + right.indices.reshape(rows, 1, m)
    ).ravel()
    values = (left.data.reshape(rows, k, 1) * right.data.reshape(rows, 1, m)).ravel()
    start = np.arange(rows + 1) * (k * m)
    return scipy.sparse.csr_array(
        (values, columns, start), shape=(rows, left.shape[1] * right.shape[1])
    )


def _roughness(n: int, periodic: bool) -> FloatArray:
    second = np.roll(np.eye(n), 1, 1) - 2.0 * np.eye(n) + np.roll(np.eye(n), -1, 1)
    if not periodic:
        second = second[1:-1]
    return np.asarray(second.T @ second)


@dataclass(frozen=True, eq=False)
class SplineModel:
    """Coefficients (size, c) in the encoded domain of a unit scale (c,), and their mean (c,)."""

    space: SplineSpace
    metric: ErrorMetric
    coefficients: FloatArray
    mean: FloatArray
    log_scale: FloatArray

    def decode(self, spline: FloatArray) -> FloatArray:
        """Return ln f_r (m, c) of the spline's values."""
        return np.asarray(self.metric.decode(spline + self.mean) + self.log_scale)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, c), 1/sr, at directions above the horizon."""
        design = self.space.design(*half_diff_from_directions(wi, wo))
        return np.exp(self.decode(design @ self.coefficients))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, c), 1/sr: the axes are contracted one by one."""
        factors = self.space.factors(grid.theta_h, grid.theta_d, grid.phi_d)
        a, b, c = (factor.toarray() for factor in factors)
        channels = self.coefficients.shape[1]
        result = np.empty((grid.cells.size, channels), dtype=np.float32)
        for channel in range(channels):
            progress("dense result", channel, channels)
            q = self.coefficients[:, channel].reshape(self.space.shape)
            full = np.einsum("ia,abc,jb,kc->ijk", a, q, b, c, optimize=True)
            # at the poles all azimuths are one direction, whose phi_d is 0
            full[0], full[:, 0] = full[0, :, :1], full[:, 0, :1]
            encoded = full.reshape(-1)[grid.cells] + self.mean[channel]
            result[:, channel] = np.exp(self.metric.decode(encoded) + self.log_scale[channel])
        progress("dense result", channels, channels)
        return grid.spread(result)

    def stddev(self, wi: FloatArray, wo: FloatArray) -> None:
        """Return None: the method states no uncertainty."""
        return None


@dataclass(frozen=True)
class LocalBasis:
    """Smoothed tensor-product splines over half/difference angles."""

    name: ClassVar[str] = "local"

    error_metric: str = "log"
    """Domain in which splines are combined and compared: linear, root or log."""
    smoothing: float = 0.1
    """Weight of the mean square second difference of the coefficients."""
    n_theta_h: int = 16
    """Splines along theta_h (square-root warped)."""
    n_theta_d: int = 10
    """Splines along theta_d."""
    n_phi_d: int = 8
    """Splines around phi_d."""

    def __post_init__(self) -> None:
        error_metric(self.error_metric)
        check_above("smoothing", self.smoothing, 0.0)
        for name in ("n_theta_h", "n_theta_d", "n_phi_d"):
            check_count(name, getattr(self, name), _DEGREE + 1)

    @property
    def space(self) -> SplineSpace:
        """The spline space of these settings."""
        return SplineSpace((self.n_theta_h, self.n_theta_d, self.n_phi_d))

    @one_thread()
    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples`; censored values are left out.

        Raises `SampleError` where no sample is usable.
        """
        samples.require_usable()
        targets = Targets.of(samples)
        positive = targets.usable & ~targets.censored
        design = self.space.design(*half_diff_from_directions(*samples.safe_directions))
        model = self.fit_design(design, np.where(positive, targets.log_value, 0.0), positive)
        estimate = model.decode(design @ model.coefficients)
        return direct_result(self, samples, model, estimate)

    def fit_design(self, design: Any, log_value: FloatArray, known: BoolArray) -> SplineModel:
        """Fit ln f_r (n, c) where `known` (n, c), from the design matrix at the samples."""
        metric = error_metric(self.error_metric)
        n_channels = log_value.shape[1]
        log_scale = np.array([np.median(log_value[known[:, c], c]) for c in range(n_channels)])
        encoded = metric.encode(log_value - log_scale)
        coefficients = np.zeros((self.space.size, n_channels))
        mean = np.zeros(n_channels)
        weights = known.astype(np.float64)
        for channels in equal_columns(weights, np.arange(n_channels)):
            rows = weights[:, channels[0]] > 0.0
            solver = self.solver(design[rows])
            values = encoded[np.ix_(rows, channels)]
            mean[channels] = values.mean(axis=0)
            coefficients[:, channels] = solver(values - mean[channels])
        return SplineModel(self.space, metric, coefficients, mean, log_scale)

    def fit_solved(
        self, solver: Callable[[FloatArray], FloatArray], log_value: FloatArray
    ) -> SplineModel:
        """Fit ln f_r (n, c), all of them known, with the `solver` of their design matrix.

        For callers that fit many times at the same directions (benchmarks).
        """
        metric = error_metric(self.error_metric)
        log_scale = np.median(log_value, axis=0)
        encoded = metric.encode(log_value - log_scale)
        mean = encoded.mean(axis=0)
        return SplineModel(self.space, metric, solver(encoded - mean), mean, log_scale)

    def solver(self, design: Any) -> Any:
        """Return a function from encoded values (n, c), mean removed, to coefficients (size, c).

        The normal equations are factorised once; what is returned is linear in the values.
        """
        n = design.shape[0]
        gram = (design.T @ design).toarray() / n
        gram += self.smoothing * self.space.penalty() + _ANCHOR * np.eye(self.space.size)
        factor = scipy.linalg.cho_factor(gram, check_finite=False)

        def solve(values: FloatArray) -> FloatArray:
            return np.asarray(scipy.linalg.cho_solve(factor, design.T @ values / n))

        return solve
