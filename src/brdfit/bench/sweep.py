"""`brdfit bench sweep`: constants that nobody published, compared on materials set apart.

The defaults of the methods are judged here and on no other material: every third of the
population, in alphabetical order (`tuning`). Each is reconstructed without itself, on the
scene of `brdfit bench paper`, from the data ratio and the outlier ratios of `SweepSettings`,
by every variant of `questions`. One record a variant, material and outlier ratio.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.bench.ledger import Record, figure, versions
from brdfit.bench.options import Say, add_run_arguments, ledger_of, share, write_page
from brdfit.bench.paper.contender import Case
from brdfit.bench.paper.scene import Scene
from brdfit.bench.paper.settings import PaperSettings
from brdfit.bench.questions import QUESTIONS, Question, Variant, contender, defaults, variants
from brdfit.bench.sweep_page import page
from brdfit.bench.tuning import used_materials
from brdfit.bench.workers import Task
from brdfit.progress import Progress

if TYPE_CHECKING:
    from brdfit.populations import Population

__all__ = ["HELP", "SweepSettings", "add_arguments", "run"]

_SCENE = PaperSettings(data_ratios=(0.1,), outlier_ratios=(0.0, 0.4, 0.8), parts=("errors",))

HELP = "compare the values of constants on materials set apart for that"

# Seconds on one core, for the estimate of time left: to prepare, and a case after that.
_COST = {"our": (6.0, 0.6), "loc": (2.0, 0.2), "tab": (60.0, 0.2)}


@dataclass(frozen=True)
class SweepSettings:
    """Everything that a figure depends on, beside the population and the code."""

    scene: PaperSettings = _SCENE
    """Universe, ratios, outliers, picture and seed of `brdfit bench paper`."""
    materials: int = 12
    """How many of the tuning materials are used, evenly spread; 0 is all."""
    questions: tuple[Question, ...] = QUESTIONS

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        shown = ("seed", "outliers", "universe", "outlier_ratios", "image_size", "grid")
        scene = self.scene.record()
        return {"data_ratio": self.data_ratio} | {name: scene[name] for name in shown}

    @property
    def data_ratio(self) -> float:
        """The one data ratio at which everything is compared."""
        return self.scene.data_ratios[0]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark."""
    parser.add_argument(
        "--population",
        default="nbrdf",
        metavar="NAME|PATH",
        help="materials, as for `brdfit bench paper` (default: nbrdf)",
    )
    parser.add_argument(
        "--materials",
        type=int,
        default=SweepSettings.materials,
        metavar="N",
        help="how many of the materials set apart are used, evenly spread; 0 is all of them "
        f"(default: {SweepSettings.materials})",
    )
    parser.add_argument(
        "--universe", type=share, default=0.05, help="share of the cells measured (default: 0.05)"
    )
    add_run_arguments(parser, "benchmarks/results/sweep.json")


def run(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    """Run the benchmark; leave the result and its page."""
    if not arguments.from_result:
        _compute(arguments, _settings(arguments), progress, say)
    write_page(arguments.output, "sweep", page, say)


def _settings(arguments: argparse.Namespace) -> SweepSettings:
    scene = replace(_SCENE, seed=arguments.seed, universe=arguments.universe)
    return SweepSettings(scene, arguments.materials)


def _population(name: str) -> Population:
    from brdfit.populations import population

    return population(name)


def _compute(
    arguments: argparse.Namespace, settings: SweepSettings, progress: Progress, say: Say
) -> None:
    population = _population(arguments.population)
    subjects = {
        population.members[subject]: subject for subject in Scene.subjects_of(_SCENE, population)
    }
    used = used_materials(subjects, settings.materials)
    header: dict[str, object] = {
        "benchmark": "sweep",
        "command": _command(arguments, settings),
        "settings": settings.record(),
        "materials": {"all": sorted(subjects), "used": used},
        "population": {
            "name": Path(population.name).name,
            "fingerprint": population.fingerprint,
            "members": len(population),
        },
        "methods": defaults(settings.questions),
        "questions": [question.record() for question in settings.questions],
        "versions": versions(),
    }
    ledger_of(arguments, header).run(
        _tasks(settings, [subjects[name] for name in used]),
        _work,
        lambda left: Scene.build(settings.scene, population, progress),
        progress,
        say,
        "sweep",
    )


def _command(arguments: argparse.Namespace, settings: SweepSettings) -> str:
    words = [
        "brdfit bench sweep",
        f"--population {Path(arguments.population).name}",
        f"--materials {settings.materials}",
        f"--universe {settings.scene.universe:g}",
        f"--seed {settings.scene.seed}",
    ]
    return " ".join(words)


def _tasks(settings: SweepSettings, subjects: Sequence[int]) -> list[Task]:
    """Return tasks in each of which the slow part, what a contender prepares, is done once.

    Correction functions prepare the basis of a material, which depends on the error metric
    alone: all variants of a metric are run on it. The others prepare for the samples'
    places: all materials are run on those.
    """
    found, cases = [], len(settings.scene.outlier_ratios)
    by_metric: dict[str, list[Variant]] = {}
    for variant in variants(settings.questions):
        if variant.method == "our":
            by_metric.setdefault(str(contender(variant).metric), []).append(variant)
        else:
            cost = _cost(variant.method, cases * len(subjects))
            found.append(Task(variant.key, ([variant], list(subjects)), cost))
    for metric, shared in by_metric.items():
        cost = _cost("our", cases * len(shared))
        found += [
            Task(f"our|{metric}|{subject:03d}", (shared, [subject]), cost) for subject in subjects
        ]
    return found


def _cost(method: str, cases: int) -> int:
    prepare, case = _COST[method]
    return max(1, round(prepare + case * cases))


def _work(scene: Scene, task: Task) -> list[Record]:
    """Return the records of one task (what a worker runs)."""
    shared, subjects = task.payload
    columns = {variant: contender(variant) for variant in shared}
    data_ratio = scene.settings.data_ratios[0]
    cases = [Case(subject, data_ratio, scene.rows(data_ratio)) for subject in subjects]
    # What is prepared is the same for all variants and cases of a task.
    prepared = columns[shared[0]].prepare(scene, cases[0])
    found = []
    for case in cases:
        for ratio in scene.settings.outlier_ratios:
            measured = scene.measured(case.subject, case.rows, data_ratio, ratio).values
            for variant, column in columns.items():
                values = column.reconstruct(scene, prepared, case, measured).values
                found.append(_record(scene, variant, case, ratio, values))
    return found


def _record(scene: Scene, variant: Variant, case: Case, ratio: float, values: Any) -> Record:
    material = scene.names[case.subject]
    return {
        "key": f"{variant.key}|{material}|o{ratio:g}",
        "variant": variant.key,
        "material": material,
        "outlier_ratio": ratio,
        "samples": int(case.rows.size),
        "error": figure(scene.perceptual_error(case.subject, values)),
    }
