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

from brdfit.arrays import FloatArray, IntArray
from brdfit.bench.ledger import Record, figure
from brdfit.bench.paper.scene import Scene
from brdfit.bench.workers import Task

__all__ = ["Case", "Contender", "ErrorWork", "error_tasks"]


@dataclass(frozen=True, eq=False)
class Case:
    """One material at one data ratio: whose measurements, and where they are."""

    subject: int
    """Member that is reconstructed."""
    data_ratio: float
    rows: IntArray
    """(n,) rows of the universe that are measured."""


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
        """Return the key of what is prepared: cases of equal keys share it."""

    def prepare(self, scene: Scene, case: Case) -> Any:
        """Return what cases of the same key share."""

    def reconstruct(
        self, scene: Scene, prepared: Any, case: Case, values: FloatArray
    ) -> FloatArray:
        """Return f_r (m, channels) at the target from `values` (n, channels), outliers among them.

        The material of `case.subject` is not to be leaned on: `scene.others(case.subject)`
        are the members that may be.
        """


@dataclass(eq=False)
class ErrorWork:
    """What a worker needs for cases: the scene, the contenders, and what it prepared last."""

    scene: Scene
    contenders: dict[str, Contender]
    _prepared: dict[str, tuple[Hashable, Any]] = field(default_factory=dict)

    def values(self, name: str, case: Case, outlier_ratio: float) -> FloatArray:
        """Return f_r (m, channels) of one case with one share of outliers."""
        contender = self.contenders[name]
        key = contender.share(case)
        if name not in self._prepared or self._prepared[name][0] != key:
            # The old one goes before the new one comes: they may be large.
            self._prepared.pop(name, None)
            self._prepared[name] = (key, contender.prepare(self.scene, case))
        measured = self.scene.measured(case.subject, case.rows, case.data_ratio, outlier_ratio)
        prepared = self._prepared[name][1]
        return contender.reconstruct(self.scene, prepared, case, measured.values)

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
                values = self.values(name, case, outlier_ratio)
                found.append(self._record(part, name, case, outlier_ratio, values))
        return found

    def _record(
        self, part: str, name: str, case: Case, outlier_ratio: float, values: FloatArray
    ) -> Record:
        material = self.scene.names[case.subject]
        reference = self.scene.reference(case.subject)
        with np.errstate(invalid="ignore", divide="ignore"):
            difference = np.abs(np.log(values / reference))
        comparable = np.isfinite(difference)
        return {
            "key": f"{part}|{name}|{material}|d{case.data_ratio:g}|o{outlier_ratio:g}",
            "part": part,
            "method": name.split(":")[0],
            "metric": self.contenders[name].metric,
            "material": material,
            "data_ratio": case.data_ratio,
            "outlier_ratio": outlier_ratio,
            "samples": int(case.rows.size),
            "error": figure(self.scene.perceptual_error(case.subject, values)),
            "log_error": figure(difference[comparable].mean()) if comparable.any() else None,
            "not_positive": int(np.count_nonzero(~comparable)),
        }


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
        probe = [Case(subject, data_ratios[0], np.arange(0)) for subject in scene_subjects[:2]]
        per_material = len({contender.share(case) for case in probe}) == len(probe)
        groups = [tuple(data_ratios)] if per_material else [(ratio,) for ratio in data_ratios]
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
