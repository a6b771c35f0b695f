"""`brdfit bench holdout`: fit a part of each real file, predict the rest.

Every measured material is taken apart in several ways (`conditions`), and the part that was
not fitted is predicted by every method with its default settings and by a log-domain RBF
interpolator that is tuned on the fitted part. One record a material, condition and method.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brdfit.bench.holdout.conditions import CONDITIONS, part_of
from brdfit.bench.holdout.judgement import judge_method, judge_rbf
from brdfit.bench.holdout.page import RBF, page
from brdfit.bench.ledger import Record, versions
from brdfit.bench.options import Say, add_run_arguments, ledger_of, share, write_page
from brdfit.bench.real_files import (
    RealCase,
    Split,
    find_cases,
    generator,
    input_hashes,
    read_case,
)
from brdfit.bench.workers import Task
from brdfit.errors import UsageError
from brdfit.progress import Progress
from brdfit.samples import Samples

if TYPE_CHECKING:
    from brdfit.reconstruct.result import Method

__all__ = ["HELP", "add_arguments", "run"]

HELP = "fit a part of each real file of a folder, predict the rest"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark."""
    parser.add_argument("--data", type=Path, metavar="DIR", help="folder of real measurements")
    parser.add_argument(
        "--fraction", type=share, default=0.2, help="share that is fitted (default: 0.2)"
    )
    parser.add_argument(
        "--conditions",
        nargs="+",
        default=list(CONDITIONS),
        metavar="NAME",
        help="what is fitted: share, a number of samples, the same with an outlier model as in "
        f"1000:factor, blind (default: {' '.join(CONDITIONS)})",
    )
    parser.add_argument(
        "--methods",
        nargs="+",
        metavar="NAME",
        help=f"methods to run (default: every one, and {RBF}); NAME:POPULATION leans on another "
        "population than the default",
    )
    parser.add_argument(
        "--files",
        nargs="+",
        metavar="TEXT",
        help="only materials whose name holds one of these (default: all)",
    )
    add_run_arguments(parser, "benchmarks/results/holdout.json")


def run(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    """Run the benchmark; leave the result and its page."""
    if not arguments.from_result:
        _compute(arguments, progress, say)
    write_page(arguments.output, "holdout", page, say)


def _compute(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    if arguments.data is None:
        raise UsageError("bench holdout: needs --data DIR, a folder of real measurements.")
    settings = Split(arguments.fraction, arguments.seed)
    methods = _chosen_methods(arguments.methods)
    conditions = list(dict.fromkeys(arguments.conditions))
    cases = _chosen_cases(find_cases(arguments.data), arguments.files)
    tasks = [
        Task(f"{case.name}|{condition}|{name}", (case, condition, name))
        for case in cases
        for condition in conditions
        for name in methods
    ]
    header = {
        "benchmark": "holdout",
        "command": _command(arguments, conditions),
        "settings": {
            "fraction": settings.fraction,
            "conditions": conditions,
            "methods": {name: _settings_of(method) for name, method in methods.items()},
        },
        "seed": settings.seed,
        "inputs": input_hashes(cases),
        "versions": versions(),
    }
    ledger = ledger_of(arguments, header)
    ledger.run(
        tasks,
        _work,
        lambda left: Shared.of(left, settings, methods),
        progress,
        say,
        "holding out",
    )


def _chosen_methods(wanted: Sequence[str] | None) -> dict[str, Method | None]:
    """Return the methods by the name of their column; the RBF interpolator is None."""
    from brdfit.reconstruct import METHODS

    known = [*METHODS, RBF]
    found: dict[str, Method | None] = {}
    for text in wanted or known:
        name, _, materials = text.partition(":")
        if name not in known or (materials and not _leans(name)):
            raise UsageError(
                f"--methods: found {text!r} but known are {', '.join(known)}, and of those that "
                f"lean on a population NAME:POPULATION."
            )
        if name == RBF:
            found[RBF] = None
        elif materials:
            found[f"{name}:{Path(materials).name}"] = METHODS[name](population=materials)
        else:
            found[name] = METHODS[name]()
    return found


def _leans(name: str) -> bool:
    from brdfit.reconstruct import METHODS

    return name in METHODS and "population" in {f.name for f in dataclasses.fields(METHODS[name])}


def _chosen_cases(cases: list[RealCase], wanted: Sequence[str] | None) -> list[RealCase]:
    if not wanted:
        return cases
    found = [case for case in cases if any(text in case.name for text in wanted)]
    if not found:
        names = ", ".join(case.name for case in cases[:5])
        raise UsageError(f"--files: no material has {wanted[0]!r} in its name; there are {names}.")
    return found


def _settings_of(method: Method | None) -> dict[str, Any]:
    from brdfit.populations import population
    from brdfit.reconstruct.result import population_record, settings_record

    if method is None:
        return {"chosen_by": "five-fold cross-validation inside the fitted part"}
    record = settings_record(method)
    if "population" in record:
        # A population given by its path is named as its file: a folder says nothing.
        found = population_record(population(record["population"]))
        record["population"] = Path(found["name"]).name
        record["fingerprint"] = found["fingerprint"]
    return record


def _command(arguments: argparse.Namespace, conditions: Sequence[str]) -> str:
    """Return the command that repeats the run; folders are named by their last part."""
    words = ["brdfit bench holdout", f"--data {arguments.data.resolve().name}"]
    if tuple(conditions) != CONDITIONS:
        words.append("--conditions " + " ".join(conditions))
    if arguments.methods:
        names = (text.partition(":") for text in arguments.methods)
        words.append(
            "--methods "
            + " ".join(f"{n}{colon}{Path(p).name if p else p}" for n, colon, p in names)
        )
    if arguments.files:
        words.append("--files " + " ".join(arguments.files))
    return " ".join([*words, f"--fraction {arguments.fraction:g}", f"--seed {arguments.seed}"])


@dataclass(frozen=True, eq=False)
class Shared:
    """What the workers share."""

    split: Split
    samples: dict[str, Samples]
    methods: dict[str, Method | None]

    @classmethod
    def of(cls, tasks: Sequence[Task], split: Split, methods: dict[str, Method | None]) -> Shared:
        """Read the files of the tasks."""
        cases: dict[str, RealCase] = {task.payload[0].name: task.payload[0] for task in tasks}
        return cls(split, {name: read_case(case) for name, case in cases.items()}, methods)


def _work(shared: Shared, task: Task) -> list[Record]:
    """Return the record of one task, none where the condition does not apply to the file."""
    case, condition, name = task.payload
    samples, how = shared.samples[case.name], shared.split
    part = part_of(case.name, samples, condition, how)
    if part is None:
        return []
    method = shared.methods[name]
    if method is None:
        own_seed = int(generator(how.seed, case.name, RBF).integers(2**31))
        record = judge_rbf(part, own_seed)
    else:
        record = judge_method(method, part)
    known = {"key": task.key, "method": name, "file": case.name, "condition": condition}
    return [known | {"samples": len(samples)} | record]
