"""`brdfit bench speed`: what each stage takes beside the least that it can take.

Each stage runs in a process of its own, one after the other, with the bandwidth and the product
rate of the machine measured there just before. Unlike the other benchmarks its figures are
times: no two runs give the same bytes.
"""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from brdfit.bench.ledger import Ledger, Record, versions
from brdfit.bench.options import Say, add_run_arguments, write_page
from brdfit.bench.real_files import RealCase, find_cases, input_hashes
from brdfit.bench.speed.job import Job, Sizes
from brdfit.bench.speed.measure import measured
from brdfit.bench.speed.page import page
from brdfit.bench.speed.stages import STAGES, Stage, reading
from brdfit.bench.workers import Task, in_own_process
from brdfit.errors import BrdfitWarning, MissingExtra, UsageError
from brdfit.progress import Progress
from brdfit.versions import version_of

__all__ = ["HELP", "add_arguments", "run"]

HELP = "seconds, memory and ratio to the least possible of every stage"

_THREADS = "OMP_NUM_THREADS"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark."""
    parser.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help="folder of real measurements: one file of each laboratory is read besides (default: "
        "only measurements that the program makes)",
    )
    parser.add_argument(
        "--population",
        default="embedded",
        metavar="NAME|PATH",
        help="materials to lean on and to measure (default: embedded)",
    )
    parser.add_argument(
        "--stages",
        nargs="+",
        metavar="NAME",
        help=f"only these (default: every one of {', '.join(STAGES)})",
    )
    parser.add_argument(
        "--items",
        type=_positive,
        default=Sizes.items,
        metavar="N",
        help=f"items of a batch (default: {Sizes.items})",
    )
    add_run_arguments(parser, "benchmarks/results/speed.json", workers=False)


def run(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    """Run the benchmark; leave the result and its page."""
    if not arguments.from_result:
        _compute(arguments, progress, say)
    write_page(arguments.output, "speed", page, say)


def _compute(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    cases = _one_a_laboratory(arguments.data)
    stages = _chosen([*STAGES.values(), *map(reading, cases)], arguments.stages)
    sizes = replace(Sizes(), items=arguments.items)
    header = {
        "benchmark": "speed",
        "command": _command(arguments),
        "settings": {
            "population": Path(arguments.population).name,
            "items": sizes.items,
            "per_item": sizes.per_item,
            "stages": {stage.name: stage.what for stage in stages},
        },
        "seed": arguments.seed,
        "inputs": input_hashes(list(cases.values())),
        "machine": _machine(),
        "versions": versions() | {"scikit-learn": version_of("scikit-learn")},
    }
    tasks = [Task(stage.name, stage.name, stage.cost) for stage in stages]
    # One at a time: side by side they would measure one another.
    ledger = Ledger(arguments.output, header, arguments.restart, workers=1)
    real = tuple((name, case.path, dict(case.options)) for name, case in cases.items())
    with tempfile.TemporaryDirectory(prefix="brdfit-speed-") as folder:
        job = Job(arguments.population, arguments.seed, sizes, Path(folder), real)
        shared = Shared(job, {stage.name: number for number, stage in enumerate(stages)})
        ledger.run(tasks, _work, lambda left: shared, progress, say, "measuring")


def _one_a_laboratory(data: Path | None) -> dict[str, RealCase]:
    """Return the first case of each laboratory by the laboratory's name."""
    found: dict[str, RealCase] = {}
    for case in find_cases(data) if data is not None else []:
        found.setdefault(case.name.split("/")[0], case)
    return found


def _chosen(stages: Sequence[Stage], wanted: Sequence[str] | None) -> list[Stage]:
    names = [stage.name for stage in stages]
    for name in wanted or ():
        if name not in names:
            raise UsageError(f"--stages: found {name!r} but known are {', '.join(names)}.")
    return [stage for stage in stages if not wanted or stage.name in wanted]


def _machine() -> dict[str, Any]:
    return {
        "cpus": os.cpu_count(),
        "platform": platform.system(),
        "processor": _processor(),
        "threads": os.environ.get(_THREADS, "as many as the library likes"),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _command(arguments: argparse.Namespace) -> str:
    """Return the command that repeats the run; folders are named by their last part."""
    words = ["brdfit bench speed", f"--population {Path(arguments.population).name}"]
    if arguments.data is not None:
        words.append(f"--data {arguments.data.resolve().name}")
    if arguments.stages:
        words.append("--stages " + " ".join(arguments.stages))
    return " ".join([*words, f"--items {arguments.items}", f"--seed {arguments.seed}"])


@dataclass(frozen=True, eq=False)
class Shared:
    """What the stages share."""

    job: Job
    order: dict[str, int]
    """Place of each stage on the page."""


def _work(shared: Shared, task: Task) -> list[Record]:
    """Return the record of one stage."""
    known = {"key": f"{shared.order[task.key]:02d}|{task.key}", "stage": task.key}
    return [known | in_own_process(measure_stage, shared.job, task.key)]


def measure_stage(job: Job, name: str) -> Record:
    """Return the figures of a stage, or why it was left out: of a package that is missing."""
    stage = STAGES.get(name) or reading(name.removeprefix("read_"))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", BrdfitWarning)
            return measured(stage.prepare(job), stage.repeat, stage.warm)
    except MissingExtra as error:
        return {"left_out": str(error)}


def _positive(text: str) -> int:
    value = int(text) if text.isdecimal() else 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"found {text!r} but expected a number of at least 1")
    return value
