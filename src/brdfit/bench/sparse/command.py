"""`brdfit bench sparse`: held-out materials from 8 to 4000 samples, every method side by side.

The published split of the 100 MERL materials: 80 to lean on, 20 to reconstruct, each from N
samples at random directions without noise. A result is judged by its rendered sphere. One
record a method, material, number of samples and draw.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.bench.ledger import Record, versions
from brdfit.bench.options import Say, add_run_arguments, ledger_of, write_page
from brdfit.bench.sparse.cases import Scene, SparseSettings, methods_of
from brdfit.bench.sparse.page import page
from brdfit.bench.sparse.published import HELD_OUT, SAMPLES
from brdfit.bench.workers import Task
from brdfit.errors import PopulationError, UsageError
from brdfit.progress import Progress

if TYPE_CHECKING:
    from brdfit.populations import Population

__all__ = ["HELP", "add_arguments", "run"]

HELP = "reconstruct held-out materials from few samples, by every method"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark."""
    parser.add_argument(
        "--population",
        default="nbrdf",
        metavar="NAME|PATH",
        help="population that holds the materials, those that are held out among them "
        "(default: nbrdf)",
    )
    parser.add_argument(
        "--lean-on",
        metavar="NAME|PATH",
        help="population that the methods lean on, without the held-out materials "
        "(default: the same)",
    )
    parser.add_argument(
        "--methods", nargs="+", metavar="NAME", help="methods to run (default: every one)"
    )
    parser.add_argument(
        "--samples",
        nargs="+",
        type=int,
        default=list(SAMPLES),
        metavar="N",
        help=f"numbers of samples (default: {' '.join(map(str, SAMPLES))})",
    )
    parser.add_argument(
        "--repeats",
        type=int,
        default=SparseSettings.repeats,
        metavar="N",
        help=f"draws of directions for each material (default: {SparseSettings.repeats})",
    )
    add_run_arguments(parser, "benchmarks/results/sparse.json")


def run(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    """Run the benchmark; leave the result and its page."""
    if not arguments.from_result:
        _compute(arguments, progress, say)
    write_page(arguments.output, "sparse", page, say)


def _compute(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    settings = SparseSettings(
        arguments.seed, tuple(sorted(set(arguments.samples))), arguments.repeats
    )
    if settings.samples[0] < 1:
        raise UsageError(f"--samples: found {settings.samples[0]} but each is at least 1.")
    references = _population(arguments.population)
    learnt = _population(arguments.lean_on or arguments.population)
    scene = Scene(
        settings,
        _only_held_out(references, settings.held_out),
        methods_of(_without_held_out(learnt, settings.held_out), arguments.methods),
    )
    tasks = [
        Task(f"{name}|{material}", (name, material))
        for name in scene.methods
        for material in settings.held_out
    ]
    ledger = ledger_of(arguments, _header(arguments, scene, references, learnt))
    ledger.run(tasks, _work, lambda left: scene, progress, say, "few samples")


def _population(name: str) -> Population:
    from brdfit.populations import population

    return population(name)


def _only_held_out(references: Population, held_out: tuple[str, ...]) -> Population:
    missing = sorted(set(held_out) - set(references.materials))
    if missing:
        raise PopulationError(
            f"population {references.name!r} lacks {len(missing)} of the {len(held_out)} held-out "
            f"materials ({missing[0]}, ...): this benchmark reconstructs MERL materials."
        )
    return references.subset(held_out)


def _without_held_out(learnt: Population, held_out: tuple[str, ...]) -> Population:
    known = [name for name in held_out if name in set(learnt.materials)]
    return learnt.without(known) if known else learnt


def _header(
    arguments: argparse.Namespace, scene: Scene, references: Population, learnt: Population
) -> dict[str, Any]:
    from brdfit.reconstruct.result import settings_record

    def described(population: Population) -> dict[str, Any]:
        name = Path(population.name).name
        return {"name": name, "fingerprint": population.fingerprint, "members": len(population)}

    records = {name: settings_record(method) for name, method in scene.methods.items()}
    for record in records.values():
        record.pop("population", None)  # named once, for all
    return {
        "benchmark": "sparse",
        "command": _command(arguments, scene.settings),
        "settings": scene.settings.record(),
        "population": described(references),
        "lean_on": described(_without_held_out(learnt, HELD_OUT)),
        "methods": records,
        "versions": versions(),
    }


def _command(arguments: argparse.Namespace, settings: SparseSettings) -> str:
    """Return the command that repeats the run; files are named by their last part."""
    words = ["brdfit bench sparse", f"--population {Path(arguments.population).name}"]
    if arguments.lean_on:
        words.append(f"--lean-on {Path(arguments.lean_on).name}")
    if arguments.methods:
        words.append("--methods " + " ".join(arguments.methods))
    if settings.samples != SAMPLES:
        words.append("--samples " + " ".join(map(str, settings.samples)))
    return " ".join([*words, f"--repeats {settings.repeats}", f"--seed {settings.seed}"])


def _work(scene: Scene, task: Task) -> list[Record]:
    """Return the records of one task (what a worker runs)."""
    return scene.records(*task.payload)
