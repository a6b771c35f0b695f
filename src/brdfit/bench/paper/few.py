"""The tables of few samples: a number of samples at random cells, some of them wrong.

Each table is a number of samples and an outlier model. There are several draws of cells, and
each material has one of them, so that a mean over materials is one over draws as well. Cells
depend on the seed and the number, outliers on these, the material and the model: never on what
else is run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from brdfit.bench.ledger import Record
from brdfit.bench.paper.contender import Case, Contender, ErrorWork, prepares_per_material
from brdfit.bench.paper.scene import Scene
from brdfit.bench.paper.settings import FewRow, PaperSettings
from brdfit.bench.workers import Task

__all__ = ["few_records", "few_tasks", "row_of"]

PART = "few"


def row_of(text: str) -> FewRow:
    """Read a row as the command line has it, 1000:factor; raise `ValueError` for others."""
    count, model = text.split(":")
    return int(count), model


def few_tasks(
    names: Sequence[str],
    contenders: dict[str, Contender],
    materials: Sequence[tuple[int, int]],
    settings: PaperSettings,
) -> list[Task]:
    """Return the tasks, of `materials` (member, number of its material).

    Where a contender prepares something for each material a task is a material; else a
    material in one table, those that are measured at the same cells in a row.
    """

    def places(part: tuple[tuple[FewRow, ...], tuple[int, int]]) -> tuple[Any, ...]:
        rows, (subject, number) = part
        count = rows[0][0]
        return count, number % settings.draws_of(count), subject, rows

    found = []
    for name in names:
        whole = prepares_per_material(contenders[name])
        groups = [settings.few] if whole else [(row,) for row in settings.few]
        parts = sorted(((rows, one) for rows in groups for one in materials), key=places)
        found += [_task(name, contenders[name], one[0], rows, settings) for rows, one in parts]
    return found


def _task(
    name: str,
    contender: Contender,
    subject: int,
    rows: Sequence[FewRow],
    settings: PaperSettings,
) -> Task:
    label = ",".join(f"{count}:{model}" for count, model in rows)
    # A fit of a hundred samples is not a thousand times quicker than one of 110,000.
    share = sum(0.02 + count / settings.grid.cells.size for count, _ in rows)
    cost = max(1, round(contender.cost * share * len(settings.outlier_ratios)))
    return Task(f"{PART}|{name}|{label}|{subject:03d}", (PART, name, subject, tuple(rows)), cost)


def few_records(work: ErrorWork, task: Task) -> list[Record]:
    """Return the records of a task of `few_tasks`."""
    _, name, subject, rows = task.payload
    scene = work.scene
    found = []
    for count, model in rows:
        case = few_case(scene, subject, count)
        for ratio in scene.settings.outlier_ratios:
            measured = scene.few(subject, case.rows, model, ratio)
            label = f"{scene.names[subject]}|{count}:{model}|o{ratio:g}"
            record: Record = {
                "key": f"{PART}|{name}|{label}",
                "part": PART,
                "outliers": model,
                "outlier_ratio": ratio,
                "draw": case.draw,
            }
            found.append(record | work.judged(name, case, measured))
    return found


def few_case(scene: Scene, subject: int, count: int) -> Case:
    """Return the case of a member and a number of samples."""
    draw = scene.draw_of(subject, count)
    ratio = count / scene.settings.grid.cells.size
    return Case(subject, ratio, scene.draws[count, draw], draw)
