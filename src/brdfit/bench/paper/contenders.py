"""The columns of the poster's tables: each method on the shared columns of a scene."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.bench.paper.contender import Answer, Case, Contender
from brdfit.bench.paper.posterior import Process
from brdfit.bench.paper.principal import Principal
from brdfit.bench.paper.scene import Scene
from brdfit.bench.paper.settings import METRICS
from brdfit.bench.paper.tab_operator import TabOperator
from brdfit.geometry import half_diff_from_directions
from brdfit.linalg import NormalEquations, nonnegative
from brdfit.reconstruct.combination import Combination, encode_members
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.reconstruct.correction_basis import CorrectionBasis, MemberGram
from brdfit.reconstruct.correction_functions import CorrectionFunctions
from brdfit.reconstruct.corrections import log_of_corrections
from brdfit.reconstruct.global_basis import GlobalBasis
from brdfit.reconstruct.local_basis import LocalBasis
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.pca_ridge import PcaRidge
from brdfit.reconstruct.posterior import Posterior
from brdfit.reconstruct.result import settings_record
from brdfit.reconstruct.tabulated import Tabulated
from brdfit.reconstruct.targets import Targets
from brdfit.transform import error_metric

if TYPE_CHECKING:
    from brdfit.populations import Population
    from brdfit.reconstruct.result import Method

__all__ = ["contenders_of", "methods_of"]

# Rows of the universe that the correction basis is fitted to; a basis has far fewer unknowns.
_TRAINING_ROWS = 20_000


def methods_of(population: Population) -> dict[str, Method]:
    """Return the methods of the tables, with their default settings, leaning on `population`."""
    return {
        "our": CorrectionFunctions(population=population),
        "glo": GlobalBasis(population=population),
        "loc": LocalBasis(),
        "tab": Tabulated(),
        "pca": PcaRidge(population=population),
        "post": Posterior(population=population),
    }


def contenders_of(population: Population) -> dict[str, Contender]:
    """Return the columns by name, and "name:metric" for the table of sensitivity."""
    our, glo = CorrectionFunctions(population=population), GlobalBasis(population=population)
    found: dict[str, Contender] = {
        "our": Corrected(our),
        "glo": Combined(glo),
        "loc": Splined(LocalBasis()),
        "tab": Interpolated(Tabulated()),
        "pca": Principal(PcaRidge(population=population)),
        "post": Process(Posterior(population=population)),
    }
    for metric in METRICS:
        found[f"our:{metric}"] = Corrected(replace(our, error_metric=metric))
        found[f"glo:{metric}"] = Combined(replace(glo, error_metric=metric))
        found[f"loc:{metric}"] = Splined(LocalBasis(error_metric=metric))
    return found


def _targets(values: FloatArray) -> Targets:
    everywhere = np.ones(values.shape, dtype=bool)
    return Targets(np.log(values), everywhere, ~everywhere)


def _record(method: Method) -> dict[str, Any]:
    """Return the settings of a method, but for the population: the run names that once."""
    return {key: value for key, value in settings_record(method).items() if key != "population"}


@dataclass(frozen=True, eq=False)
class Combined:
    """The global basis. All its cases of a data ratio share one Gram matrix a channel.

    The same equations as `GlobalBasis.fit`: the members that must not be leaned on are left
    out of them, and have coefficient 0 in the combination.
    """

    method: GlobalBasis
    title: str = "Glo"
    cost: int = 20

    @property
    def metric(self) -> str | None:
        """The error metric of the method."""
        return self.method.error_metric

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        return _record(self.method)

    def share(self, case: Case) -> Hashable:
        """Cases of a data ratio share their equations."""
        return case.places

    def prepare(self, scene: Scene, case: Case) -> list[tuple[FloatArray, FloatArray]]:
        """Return (encoded members at the samples, their Gram matrix) of each channel."""
        metric = error_metric(self.method.error_metric)
        found: list[tuple[FloatArray, FloatArray]] = []
        for channel in scene.at_universe:
            x = encode_members(channel[case.rows], metric)
            found.append((x, (x.T @ x).astype(np.float64)))
        return found

    def reconstruct(
        self,
        scene: Scene,
        prepared: list[tuple[FloatArray, FloatArray]],
        case: Case,
        values: FloatArray,
    ) -> Answer:
        """Return f_r (m, channels) at the target."""
        metric = error_metric(self.method.error_metric)
        free = int(metric.needs_constant)
        members = len(scene.names)
        columns = np.append(scene.others(case.subject), np.arange(members, members + free))
        encoded = metric.encode(np.log(values))
        coefficients = np.zeros((len(prepared), members + free))
        for channel, (x, gram) in enumerate(prepared):
            y = encoded[:, channel]
            moment = (y.astype(x.dtype) @ x).astype(np.float64)[columns]
            equations = NormalEquations(
                gram[np.ix_(columns, columns)], moment, float(y.size), np.asarray(y @ y)
            )
            coefficients[channel, columns] = nonnegative(equations, free)
        combination = Combination(metric, np.arange(len(prepared)), coefficients)
        return Answer(np.exp(combination.log_value(MemberRows(tuple(scene.at_target)))))


@dataclass(eq=False)
class Corrected:
    """Correction functions. All cases of a material share its leave-one-out basis."""

    method: CorrectionFunctions
    title: str = "Our"
    cost: int = 100
    _gram: dict[int, MemberGram] = field(default_factory=dict, repr=False)

    @property
    def metric(self) -> str | None:
        """The error metric of the method."""
        return self.method.error_metric

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        return _record(self.method)

    def share(self, case: Case) -> Hashable:
        """Cases of a material share its basis."""
        return case.subject

    def prepare(self, scene: Scene, case: Case) -> MaterialBasis:
        """Return the basis that knows nothing of the case's material."""
        if id(scene) not in self._gram:
            self._gram[id(scene)] = _training_gram(scene, self.method)
        return MaterialBasis.of(scene, case.subject, self._gram[id(scene)])

    def reconstruct(
        self, scene: Scene, prepared: MaterialBasis, case: Case, values: FloatArray
    ) -> Answer:
        """Return f_r (m, channels) at the target."""
        rows, basis_values = prepared.at(case)
        roles = np.arange(scene.n_channels)
        combination, loop = self.method.fit_rows(
            rows, _targets(values), roles, prepared.basis, basis_values
        )
        log_value = combination.log_value(prepared.target)
        if loop.corrections:
            log_value = log_value + log_of_corrections(loop.corrections, prepared.target_values)
        return Answer(np.exp(log_value))


@dataclass(eq=False)
class MaterialBasis:
    """The other members and their correction functions, at the universe and at the target."""

    basis: CorrectionBasis
    universe: MemberRows
    universe_values: FloatArray
    target: MemberRows
    target_values: FloatArray
    _case: tuple[Hashable, MemberRows, FloatArray] | None = None

    @classmethod
    def of(cls, scene: Scene, subject: int, gram: MemberGram) -> MaterialBasis:
        """Build the correction functions of the other materials without this one."""
        others = scene.others(subject)
        left_out = np.setdiff1d(np.arange(len(scene.names)), others)
        materials = tuple(str(scene.materials[member]) for member in others)
        basis = CorrectionBasis.build(gram.without(left_out), materials)
        universe = _rows(scene.at_universe, others)
        target = _rows(scene.at_target, others)
        return cls(basis, universe, basis.evaluate(universe), target, basis.evaluate(target))

    def at(self, case: Case) -> tuple[MemberRows, FloatArray]:
        """Return members and correction functions at the measurements of a case."""
        if self._case is None or self._case[0] != case.places:
            self._case = None
            taken = self.universe.take(case.rows), self.universe_values[case.rows]
            self._case = (case.places, *taken)
        return self._case[1], self._case[2]


@dataclass(frozen=True, eq=False)
class SplineSystem:
    """Design matrices at the samples and at the target, and the factorised equations."""

    samples: Any
    target: Any
    solve: Callable[[FloatArray], FloatArray]


@dataclass(eq=False)
class Splined:
    """The local basis. All cases of a data ratio share its factorised equations."""

    method: LocalBasis
    title: str = "Loc"
    cost: int = 20
    _target: dict[int, Any] = field(default_factory=dict, repr=False)

    @property
    def metric(self) -> str | None:
        """The error metric of the method."""
        return self.method.error_metric

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        return _record(self.method)

    def share(self, case: Case) -> Hashable:
        """Cases of a data ratio share their equations."""
        return case.places

    def prepare(self, scene: Scene, case: Case) -> SplineSystem:
        """Return the equations at the cells of the case."""
        space = self.method.space
        if id(scene) not in self._target:
            design = space.design(*half_diff_from_directions(*scene.target))
            self._target[id(scene)] = design.astype(np.float32)
        design = space.design(*half_diff_from_directions(*scene.directions(case.rows)))
        return SplineSystem(design, self._target[id(scene)], self.method.solver(design))

    def reconstruct(
        self, scene: Scene, prepared: SplineSystem, case: Case, values: FloatArray
    ) -> Answer:
        """Return f_r (m, channels) at the target."""
        model = self.method.fit_solved(prepared.solve, np.log(values))
        spline = prepared.target @ model.coefficients.astype(np.float32)
        return Answer(np.exp(model.decode(spline)))


@dataclass(frozen=True, eq=False)
class Interpolated:
    """The tabulated method. All cases of a data ratio share its interpolation weights."""

    method: Tabulated
    title: str = "Tab"
    cost: int = 20

    @property
    def metric(self) -> str | None:
        """An interpolant has none."""
        return None

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        return _record(self.method)

    def share(self, case: Case) -> Hashable:
        """Cases of a data ratio share their weights."""
        return case.places

    def prepare(self, scene: Scene, case: Case) -> TabOperator:
        """Return the weights from the cells of the case to the target."""
        samples, places = (
            half_diff_features(*half_diff_from_directions(*directions))
            for directions in (scene.directions(case.rows), scene.target)
        )
        return TabOperator.build(self.method, samples, places)

    def reconstruct(
        self, scene: Scene, prepared: TabOperator, case: Case, values: FloatArray
    ) -> Answer:
        """Return f_r (m, channels) at the target."""
        return Answer(prepared.apply(values))


def _rows(columns: FloatArray, members: IntArray) -> MemberRows:
    return MemberRows(tuple(channel[:, members] for channel in columns))


def _training_gram(scene: Scene, method: CorrectionFunctions) -> MemberGram:
    rows = scene.order[:_TRAINING_ROWS]
    every = MemberRows(tuple(channel[rows] for channel in scene.at_universe))
    return MemberGram.of(every, error_metric(method.error_metric))
