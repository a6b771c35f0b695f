"""What a method must offer to stand in the poster's tables, and how its cases are worked.

A contender sees the columns of the population at the measurements and at the target and gives
values at the target. What does not change from case to case, an interpolation operator, a
factorised system, the correction basis of a material, is prepared once: `share` names what
cases have in common, and a worker keeps the last thing prepared for each contender.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.bench.ledger import Record, figure
from brdfit.bench.outliers import Contaminated
from brdfit.bench.paper.scene import Scene
from brdfit.bench.verdicts import deviation, judged
from brdfit.bench.workers import Task
from brdfit.errors import BrdfitError

__all__ = [
    "Answer",
    "Case",
    "Contender",
    "ErrorWork",
    "error_tasks",
    "prepares_per_material",
]


@dataclass(frozen=True, eq=False)
class Case:
    """One material and its measurements: whose, and where they are."""

    subject: int
    """Member that is reconstructed."""
    data_ratio: float
    """Share of the universe; of few samples, of the grid's cells."""
    rows: IntArray
    """(n,) rows of the universe that are measured."""
    draw: int = 0
    """Which draw of few samples; the data of a ratio are the same for all."""

    @property
    def places(self) -> Hashable:
        """A key of the directions: cases of equal places are measured at the same ones."""
        return self.data_ratio, self.draw


@dataclass(frozen=True, eq=False)
class Answer:
    """What a contender makes of a case."""

    values: FloatArray
    """f_r (m, channels) at the target."""
    named: BoolArray | None = None
    """(n,) the samples that it takes for outliers; None where it does not judge them."""
    noise: float = 0.0
    """ln f_r: what it takes for the noise of a good sample."""
    seconds: float | None = None
    """How long the fit took; None where cases share its work."""


class Contender(Protocol):
    """A method in the tables."""

    @property
    def title(self) -> str:
        """What the tables call it."""

    @property
    def cost(self) -> int:
        """How long a case takes beside one of the others, for the estimate of time left."""

    @property
    def metric(self) -> str | None:
        """The error metric of its settings, None where there is none."""

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""

    def share(self, case: Case) -> Hashable:
        """Return the key of what is prepared: cases of equal keys share it.

        None is what all cases share, and is prepared once for all workers.
        """

    def prepare(self, scene: Scene, case: Case) -> Any:
        """Return what cases of the same key share."""

    def reconstruct(self, scene: Scene, prepared: Any, case: Case, values: FloatArray) -> Answer:
        """Return the values at the target from `values` (n, channels), outliers among them.

        The material of `case.subject` is not to be leaned on: `scene.others(case.subject)`
        are the members that may be.
        """


@dataclass(eq=False)
class ErrorWork:
    """What a worker needs for cases: the scene, the contenders, and what it prepared last."""

    scene: Scene
    contenders: dict[str, Contender]
    _prepared: dict[str, tuple[Hashable, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, contender in self.contenders.items():
            case = Case(0, 1.0, np.arange(0))
            if contender.share(case) is None:
                self._prepared[name] = (None, contender.prepare(self.scene, case))

    def answer(self, name: str, case: Case, values: FloatArray) -> Answer:
        """Return what a contender makes of measurements `values` (n, channels)."""
        contender = self.contenders[name]
        key = contender.share(case)
        if name not in self._prepared or self._prepared[name][0] != key:
            # The old one goes before the new one comes: they may be large.
            self._prepared.pop(name, None)
            self._prepared[name] = (key, contender.prepare(self.scene, case))
        return contender.reconstruct(self.scene, self._prepared[name][1], case, values)

    def values(self, name: str, case: Case, outlier_ratio: float) -> FloatArray:
        """Return f_r (m, channels) of one case with one share of outliers."""
        return self.answer(name, case, self._measured(case, outlier_ratio).values).values

    def case(self, subject: int, data_ratio: float) -> Case:
        """Return the case of a material and a data ratio."""
        return Case(subject, data_ratio, self.scene.rows(data_ratio))

    def records(self, task: Task) -> list[Record]:
        """Return the records of a task of `error_tasks`."""
        part, name, subject, data_ratios, outlier_ratios = task.payload
        found = []
        for data_ratio in data_ratios:
            case = self.case(subject, data_ratio)
            for outlier_ratio in outlier_ratios:
                measured = self._measured(case, outlier_ratio)
                record = {
                    "key": f"{part}|{name}|{self.scene.names[subject]}"
                    f"|d{data_ratio:g}|o{outlier_ratio:g}",
                    "part": part,
                    "outlier_ratio": outlier_ratio,
                }
                found.append(record | self.judged(name, case, measured))
        return found

    def judged(self, name: str, case: Case, measured: Contaminated) -> Record:
        """Return the figures of one case: its error, and how well outliers were named.

        A fit that is refused leaves its reason and no figures.
        """
        record: Record = {
            "method": name.split(":")[0],
            "metric": self.contenders[name].metric,
            "material": self.scene.names[case.subject],
            "data_ratio": figure(case.data_ratio),
            "samples": int(case.rows.size),
        }
        try:
            answer = self.answer(name, case, measured.values)
        except BrdfitError as error:
            return record | {"error": None, "refused": f"{type(error).__name__}: {error}"}
        with np.errstate(invalid="ignore", divide="ignore"):
            difference = np.abs(np.log(answer.values / self.scene.reference(case.subject)))
        comparable = np.isfinite(difference)
        record |= {
            "error": figure(self.scene.perceptual_error(case.subject, answer.values)),
            "log_error": figure(difference[comparable].mean()) if comparable.any() else None,
            "not_positive": int(np.count_nonzero(~comparable)),
        }
        if answer.named is not None:
            clean = self.scene.values(case.subject, case.rows)
            moved = deviation(clean, measured.values)
            record |= judged(answer.named, measured.mask, moved, answer.noise)
        if answer.seconds is not None:
            record["seconds"] = round(answer.seconds, 3)
        return record

    def _measured(self, case: Case, outlier_ratio: float) -> Contaminated:
        return self.scene.measured(case.subject, case.rows, case.data_ratio, outlier_ratio)


def error_tasks(
    part: str,
    names: Sequence[str],
    contenders: dict[str, Contender],
    scene_subjects: Sequence[int],
    data_ratios: Sequence[float],
    outlier_ratios: Sequence[float],
) -> list[Task]:
    """Return the tasks of one part: cases that share a preparation follow one another.

    Where a contender prepares per material, a task is a material; where it prepares per
    data ratio, a task is one material at one data ratio, all materials of a ratio in a row.
    """
    tasks = []
    for name in names:
        contender = contenders[name]
        whole = prepares_per_material(contender)
        groups = [tuple(data_ratios)] if whole else [(ratio,) for ratio in data_ratios]
        for group in groups:
            for subject in scene_subjects:
                label = ",".join(f"d{ratio:g}" for ratio in group)
                tasks.append(
                    Task(
                        f"{part}|{name}|{label}|{subject:03d}",
                        (part, name, int(subject), group, tuple(outlier_ratios)),
                        cost=max(1, round(contender.cost * sum(group) * len(outlier_ratios))),
                    )
                )
    return tasks


def prepares_per_material(contender: Contender) -> bool:
    """Return whether a contender prepares something for each material."""
    keys = {contender.share(Case(subject, 1.0, np.arange(0))) for subject in (0, 1)}
    return len(keys) == 2
