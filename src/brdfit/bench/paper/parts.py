"""A run of the poster's tables: its tasks, what its workers share, and its pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.bench.ledger import Record, figure
from brdfit.bench.paper.contender import Contender, ErrorWork, error_tasks
from brdfit.bench.paper.contenders import contenders_of, methods_of
from brdfit.bench.paper.expressiveness import Expressiveness
from brdfit.bench.paper.few import few_records, few_tasks
from brdfit.bench.paper.figures import heat_maps, outlier_curves, worst_spheres
from brdfit.bench.paper.poster import TITLES
from brdfit.bench.paper.scene import Scene
from brdfit.bench.paper.settings import PaperSettings
from brdfit.bench.paper.summary import Summary
from brdfit.bench.real_files import (
    RealCase,
    Split,
    find_cases,
    fit_method,
    input_hashes,
    predict_rest,
    read_case,
)
from brdfit.bench.workers import Task
from brdfit.errors import UsageError
from brdfit.progress import Progress
from brdfit.reconstruct.correction_functions import CorrectionFunctions
from brdfit.transform import error_metric

if TYPE_CHECKING:
    from brdfit.populations import Population
    from brdfit.reconstruct.result import Method

__all__ = ["COLUMNS", "Run", "charts", "work"]

COLUMNS = (*TITLES, "post")
"""The columns that are made unless others are asked for: the poster's, and the posterior."""

_WORST = 5
_WORST_OUTLIERS = 0.4


@dataclass(frozen=True, eq=False)
class Run:
    """What is to be computed; nothing is computed yet."""

    settings: PaperSettings
    population: Population
    contenders: dict[str, Contender]
    """Columns of the tables, and "name:metric" for the table of sensitivity."""
    methods: dict[str, Method]
    """The same methods as a user calls them, for the real files."""
    cases: tuple[RealCase, ...]

    @classmethod
    def plan(
        cls,
        settings: PaperSettings,
        population: Population,
        data: Path | None,
        names: Sequence[str] | None,
    ) -> Run:
        """Return the run of these settings; `names` are the columns, None is `COLUMNS`."""
        contenders = contenders_of(population)
        known = [name for name in contenders if ":" not in name]
        unknown = sorted(set(names or ()) - set(known))
        if unknown:
            raise UsageError(f"--methods: found {unknown[0]!r} but known are {', '.join(known)}.")
        wanted = set(names or COLUMNS)
        return cls(
            settings=settings,
            population=population,
            contenders={
                name: contender
                for name, contender in contenders.items()
                if name.split(":")[0] in wanted
            },
            methods={
                name: method for name, method in methods_of(population).items() if name in wanted
            },
            cases=tuple(find_cases(data)) if data and "real" in settings.parts else (),
        )

    @property
    def tasks(self) -> list[Task]:
        """Everything that is to be computed, the long parts first."""
        settings, found = self.settings, list[Task]()
        subjects = Scene.subjects_of(settings, self.population)
        if "errors" in settings.parts:
            names = [name for name in self.contenders if ":" not in name]
            ratios = settings.data_ratios, settings.outlier_ratios
            found += error_tasks("errors", names, self.contenders, subjects, *ratios)
        if "few" in settings.parts:
            found += self._few_tasks(subjects)
        if "sensitivity" in settings.parts:
            names = [name for name in self.contenders if ":" in name]
            if "errors" in settings.parts and 0.0 in settings.outlier_ratios:
                # The metric of the tables of errors is among their cells already.
                names = [name for name in names if not self._is_tabled(name)]
            ratios = (max(settings.data_ratios),), (0.0,)
            found += error_tasks("sensitivity", names, self.contenders, subjects, *ratios)
        if "expressiveness" in settings.parts:
            found += [
                Task(f"expressiveness|{subject:03d}", ("expressiveness", subject))
                for subject in subjects
            ]
        found += [
            Task(f"real|{name}|{case.name}", ("real", name, case))
            for name in self.methods
            for case in self.cases
        ]
        return found

    def _few_tasks(self, subjects: Sequence[int]) -> list[Task]:
        names = [name for name in self.contenders if ":" not in name]
        _, numbers = np.unique(np.array(self.population.materials), return_inverse=True)
        materials = [(subject, int(np.ravel(numbers)[subject])) for subject in subjects]
        return few_tasks(names, self.contenders, materials, self.settings)

    def _is_tabled(self, name: str) -> bool:
        base = name.split(":")[0]
        return base in self.contenders and self.contenders[base].metric == name.split(":")[1]

    def method_records(self) -> dict[str, Any]:
        """Return the settings of every column."""
        return {name: one.record() for name, one in self.contenders.items() if ":" not in name}

    def input_hashes(self) -> dict[str, str]:
        """Return the hashes of the real files."""
        return input_hashes(list(self.cases))

    def prepared(self, tasks: Sequence[Task], progress: Progress) -> Shared:
        """Return what the workers share."""
        needs_scene = any(task.payload[0] != "real" for task in tasks)
        scene = Scene.build(self.settings, self.population, progress) if needs_scene else None
        return Shared(
            errors=None if scene is None else ErrorWork(scene, self._used(tasks)),
            methods=self.methods,
            samples={case.name: read_case(case) for case in self.cases},
            split=Split(self.settings.fraction, self.settings.seed),
        )

    def _used(self, tasks: Sequence[Task]) -> dict[str, Contender]:
        """Return the contenders of these tasks: the others need nothing prepared."""
        names = {task.payload[1] for task in tasks}
        return {name: one for name, one in self.contenders.items() if name in names}

    def pictures(self, records: Sequence[Record], folder: Path, progress: Progress) -> None:
        """Draw the worst materials of our method beside their references."""
        summary = Summary(records)
        if "our" not in self.contenders or "errors" not in self.settings.parts:
            return
        data = min(self.settings.data_ratios)
        ratios = self.settings.outlier_ratios
        outliers = min(ratios, key=lambda ratio: abs(ratio - _WORST_OUTLIERS))
        names = summary.worst("our", outliers, data, _WORST)
        scene = Scene.build(self.settings, self.population, progress)
        work = ErrorWork(scene, {"our": self.contenders["our"]})
        found = []
        progress("worst spheres", 0, len(names))
        for index, name in enumerate(names):
            subject = scene.names.index(name)
            values = work.values("our", work.case(subject, data), outliers)
            error = scene.perceptual_error(subject, values)
            pair = [scene.view.shade(one) for one in (scene.reference(subject), values)]
            found.append((f"{name}\n{error:.2f}", pair[0], pair[1]))
            progress("worst spheres", index + 1, len(names))
        folder.mkdir(parents=True, exist_ok=True)
        title = f"the worst {len(names)}: data ratio {data:g}, outlier ratio {outliers:g}"
        worst_spheres(found, title, folder / "worst.png")


@dataclass(eq=False)
class Shared:
    """What every worker is handed."""

    errors: ErrorWork | None
    methods: dict[str, Method]
    samples: dict[str, Any]
    split: Split
    _functions: Expressiveness | None = None

    def records(self, task: Task) -> list[Record]:
        """Return the records of one task."""
        part = task.payload[0]
        if part == "real":
            return [self._real(task.payload[1], task.payload[2])]
        assert self.errors is not None
        if part == "expressiveness":
            return [self._expressiveness(self.errors.scene, task.payload[1])]
        if part == "few":
            return few_records(self.errors, task)
        return self.errors.records(task)

    def _expressiveness(self, scene: Scene, subject: int) -> Record:
        if self._functions is None:
            metric = error_metric(CorrectionFunctions.error_metric)
            self._functions = Expressiveness.of(scene, metric)
        name = scene.names[subject]
        material, part = int(scene.materials[subject]), "expressiveness"
        return {
            "key": f"{part}|{name}",
            "part": part,
            "material": name,
            "deviation": figure(self._functions.deviation(material)),
            "deviation_by_all": figure(self._functions.deviation_by_all(material)),
        }

    def _real(self, name: str, case: RealCase) -> Record:
        record = predict_rest(
            case.name,
            self.samples[case.name],
            self.split,
            lambda samples: fit_method(self.methods[name], samples),
        )
        return {"key": f"real|{name}|{case.name}", "part": "real", "method": name, **record}


def work(shared: Shared, task: Task) -> list[Record]:
    """Return the records of one task (what a worker runs)."""
    return shared.records(task)


def charts(content: dict[str, Any], folder: Path) -> dict[str, Path]:
    """Draw the figures that records suffice for; return all figures of the run by name."""
    summary = Summary(content["records"])
    if not summary.part("errors"):
        return {}
    folder.mkdir(parents=True, exist_ok=True)
    figures = {"heat_maps": folder / "heat_maps.png", "outliers": folder / "outliers.png"}
    heat_maps(summary, figures["heat_maps"])
    outlier_curves(summary, min(content["settings"]["data_ratios"]), figures["outliers"])
    if (folder / "worst.png").exists():
        figures["worst"] = folder / "worst.png"
    return figures
