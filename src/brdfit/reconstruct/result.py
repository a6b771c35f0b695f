"""`Reconstruction`: what a fit returns, whatever the method."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import cached_property
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from brdfit.albedo import directional_albedo
from brdfit.arrays import BoolArray, FloatArray, IntArray, as_unit_directions
from brdfit.display import Shown
from brdfit.errors import UsageError
from brdfit.geometry import split_by_horizon
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations import Population
from brdfit.progress import Progress, silent
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.outliers import find_outliers
from brdfit.reconstruct.targets import Targets
from brdfit.reconstruct.trust import TrustMap
from brdfit.samples import Samples, Source
from brdfit.table import Table
from brdfit.versions import versions_of

if TYPE_CHECKING:
    from brdfit.reconstruct.energy import LimitedAlbedo

__all__ = [
    "Method",
    "Model",
    "Reconstruction",
    "direct_result",
    "population_record",
    "settings_record",
]


class Model(Protocol):
    """A fitted function of direction: what a method computes and a result carries."""

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels) > 0 at directions above the horizon."""

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        """Return f_r (*grid.shape, channels), float32; 0 below the horizon."""

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        """Return the standard deviation of ln f_r (n, channels), or None if unknown."""


@runtime_checkable
class KnowsItsTails(Protocol):
    """A model whose errors are not normal, and that knows how they are instead."""

    def deviations(self, level: float) -> float:
        """Return how many stated deviations hold a share `level` of good measurements."""


@runtime_checkable
class SeesItself(Protocol):
    """A model that looks at its dense values while it makes them."""

    def seen_dense(self, grid: Grid, progress: Progress) -> tuple[FloatArray, bool]:
        """Return what `Model.dense` does, and whether all of it was seen to be finite."""


class Method(Protocol):
    """Frozen settings that can fit."""

    name: ClassVar[str]

    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        """Return the reconstruction of `samples`."""


@dataclass(frozen=True, eq=False)
class Reconstruction(Shown):
    """The complete BRDF, what became of each sample, and how the fit ended.

    | name                | shape         | meaning                                          |
    |---------------------|---------------|--------------------------------------------------|
    | `weights`           | (n,)          | robust weight in [0, 1]; 0 for unused samples    |
    | `channel_weights`   | (n, channels) | the same per channel; equal columns where pooled |
    | `residuals`         | (n, channels) | ln(value / result); NaN where not comparable     |
    | `initial_residuals` | (n, channels) | the same against the initial estimate            |
    | `outliers`          | (n,)          | usable, and named as wrong by `outlier_rule`     |
    """

    samples: Samples
    method: Method
    model: Model
    channel_weights: FloatArray
    residuals: FloatArray
    initial_residuals: FloatArray
    outliers: BoolArray
    outlier_rule: str
    """The rule that named them, in words, with its figures."""
    outcome: Outcome
    iterations: int = 0
    population: dict[str, Any] = field(default_factory=dict)
    """Name, fingerprint and member count of the population that was leaned on."""
    history: tuple[dict[str, float], ...] = ()
    """One record of figures per iteration."""

    @cached_property
    def weights(self) -> FloatArray:
        """(n,) mean weight over the channels in use; 0 for unused samples."""
        used = self.samples.usable & np.isfinite(self.channel_weights)
        total = np.where(used, self.channel_weights, 0.0).sum(axis=1)
        return np.asarray(total / np.maximum(used.sum(axis=1), 1))

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels), 1/sr, at direction pairs (n, 3).

        0 below the horizon, NaN where a direction is not finite. Raises `UsageError` for
        vectors that are not of unit length.
        """
        wi, wo = as_unit_directions("wi", wi), as_unit_directions("wo", wo)
        finite, above = split_by_horizon(wi, wo)
        result = np.full((len(above), self.samples.n_channels), np.nan)
        result[finite] = 0.0
        if above.any():
            result[above] = self.model.evaluate(wi[above], wo[above])
        return result

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return the standard deviation of ln f_r (n, channels).

        Raises `UsageError` for a method that does not know it.
        """
        deviation = self.model.stddev(as_unit_directions("wi", wi), as_unit_directions("wo", wo))
        if deviation is None:
            raise UsageError(
                f"method {self.method.name!r} states no uncertainty; residuals and weights are "
                f"what it knows of its own quality."
            )
        return deviation

    def deviations(self, level: float = 0.95) -> float:
        """Return how many `stddev`, to either side, hold a share `level` in (0, 1) of the truth.

        As the method's own left-out samples tell; else as a normal distribution has it.
        """
        if not 0.0 < level < 1.0:
            raise UsageError(f"level: found {level}, expected a share between 0 and 1.")
        if isinstance(self.model, KnowsItsTails):
            return self.model.deviations(level)
        return NormalDist().inv_cdf(0.5 + 0.5 * level)

    @cached_property
    def trust_map(self) -> TrustMap:
        """Where the result comes from, direction by direction."""
        return TrustMap.of(self)

    def trust(self, wi: FloatArray, wo: FloatArray) -> IntArray:
        """Return the `Trust` (n,) of direction pairs (n, 3): measured, interpolated, supplied.

        As integers, 0 below the horizon. `trust_map.definition` says what they mean.
        """
        return self.trust_map.evaluate(as_unit_directions("wi", wi), as_unit_directions("wo", wo))

    def table(self, grid: Grid = MERL_GRID, progress: Progress = silent) -> Table:
        """Return the dense result on `grid`; every cell above the horizon is valid."""
        if isinstance(self.model, SeesItself):
            values, finite = self.model.seen_dense(grid, progress)
        else:
            values, finite = self.model.dense(grid, progress), False
        values.flags.writeable = False  # handed over: the table need not copy it
        return Table(
            values=values,
            known_finite=finite,
            grid=grid,
            wavelengths=self.samples.wavelengths,
            channels=self.samples.channels,
            source=Source(
                name=self.samples.source.name,
                format="reconstruction",
                sha256=self.samples.source.sha256,
                convention="f_r in 1/sr, cosine not included",
                notes=(f"method {self.method.name}", f"outcome {self.outcome.value}"),
            ),
        )

    def albedo(self, theta_i: npt.ArrayLike) -> FloatArray:
        """Return the directional albedo (angles, channels) at `theta_i` (angles,), radians.

        Above 1 no surface can be. Raises `UsageError` for an angle outside [0, pi/2).
        """
        return directional_albedo(self, theta_i)

    def limited_table(
        self, grid: Grid = MERL_GRID, progress: Progress = silent, *, albedo: float = 1.0
    ) -> LimitedAlbedo:
        """Return the dense result whose directional albedo is at most `albedo`, and the cost.

        Values give way where nobody measured; measured cells are not moved. If that is not
        enough, `reached` is False and `sentence` says at which incidences. Raises `UsageError`
        for an albedo that is not above 0.
        """
        from brdfit.reconstruct.energy import limit_albedo

        return limit_albedo(self, self.table(grid, progress), limit=albedo, progress=progress)

    def record(self) -> dict[str, Any]:
        """Return everything a script needs to know about the fit, as JSON-able values."""
        return {
            "method": settings_record(self.method),
            "population": dict(self.population),
            "outcome": {
                "name": self.outcome.value,
                "ok": self.outcome.ok,
                "advice": self.outcome.advice,
            },
            "iterations": self.iterations,
            "history": list(self.history),
            "samples": {
                "count": len(self.samples),
                "usable": int(self.samples.usable.any(axis=1).sum()),
                "channels": list(self.samples.channels),
                "flags": self.samples.flag_counts(),
                "source": dataclasses.asdict(self.samples.source),
            },
            "outliers": {
                "count": int(self.outliers.sum()),
                "rule": self.outlier_rule,
                "rows": _rows(self.samples, self.outliers),
            },
            "residuals": {
                "definition": "ln(value / result)",
                "before": _summary(self.initial_residuals),
                "after": _summary(self.residuals),
                "after_without_outliers": _summary(self.residuals[~self.outliers]),
            },
            "versions": versions_of("brdfit", "numpy", "scipy"),
        }


def direct_result(
    method: Method,
    samples: Samples,
    model: Model,
    log_estimate: FloatArray,
    population: dict[str, Any] | None = None,
) -> Reconstruction:
    """Return the result of a method without robust weights, solved in one step.

    `log_estimate` (n, c) is ln of the result at the samples. Every usable sample weighs 1;
    outliers are named by the same rule as everywhere. A fit of too few samples, or of
    samples that mostly disagree with it, says so in its outcome.
    """
    residuals = np.where(samples.usable, Targets.of(samples).residual(log_estimate), np.nan)
    outliers = find_outliers(residuals, samples.usable, per_channel=False)
    return Reconstruction(
        samples=samples,
        method=method,
        model=model,
        channel_weights=samples.usable.astype(np.float64),
        residuals=residuals,
        initial_residuals=residuals,
        outliers=outliers.rows,
        outlier_rule=outliers.rule,
        outcome=outliers.outcome(Outcome.DIRECT),
        population=population or {},
    )


def settings_record(method: Method) -> dict[str, Any]:
    """Return a method's name and settings as JSON-able values."""
    record: dict[str, Any] = {"name": method.name}
    for item in dataclasses.fields(method):  # type: ignore[arg-type]
        value = getattr(method, item.name)
        plain = value is None or isinstance(value, bool | int | float | str)
        record[item.name] = value if plain else str(value)
    return record


def population_record(materials: Population) -> dict[str, Any]:
    """Return what identifies a population, as JSON-able values."""
    return {
        "name": materials.name,
        "fingerprint": materials.fingerprint,
        "members": len(materials),
        "materials": len(materials.unique_materials),
    }


def _rows(samples: Samples, chosen: BoolArray) -> list[int]:
    index = np.flatnonzero(chosen)
    return [int(row) for row in (index + 1 if samples.rows is None else samples.rows[index])]


def _summary(residuals: FloatArray) -> dict[str, float | int | None]:
    size = np.abs(residuals[np.isfinite(residuals)])
    if size.size == 0:
        return {"count": 0, "median_abs": None, "mean_abs": None, "rms": None}
    return {
        "count": int(size.size),
        "median_abs": float(np.median(size)),
        "mean_abs": float(size.mean()),
        "rms": float(np.sqrt(np.mean(size**2))),
    }
