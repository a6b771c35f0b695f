"""`brdfit bench holdout`: fit a part of each real file, predict the rest.

For every measured material a random share of its usable samples (20 % by default) is fitted
and the others are predicted, by every method with its default settings and by a log-domain
RBF interpolator that is tuned on the fitted part. There is no target: the table is the
result. One record a material and method.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from brdfit.bench.ledger import Record, versions
from brdfit.bench.log_rbf import LogRbf
from brdfit.bench.markdown import Column, cell, table
from brdfit.bench.options import Say, add_run_arguments, ledger_of, share
from brdfit.bench.real_files import (
    Evaluate,
    RealCase,
    Split,
    find_cases,
    fit_method,
    generator,
    input_hashes,
    predict_rest,
    read_case,
)
from brdfit.bench.workers import Task
from brdfit.files import atomic_path
from brdfit.progress import Progress
from brdfit.samples import Samples

__all__ = ["HELP", "add_arguments", "run"]

HELP = "fit a part of each real file of a folder, predict the rest"

RBF = "log_rbf"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this benchmark."""
    parser.add_argument(
        "--data", type=Path, required=True, metavar="DIR", help="folder of real measurements"
    )
    parser.add_argument(
        "--fraction", type=share, default=0.2, help="share that is fitted (default: 0.2)"
    )
    parser.add_argument(
        "--methods",
        nargs="+",
        metavar="NAME",
        help=f"methods to run (default: every one, and {RBF})",
    )
    add_run_arguments(parser, "benchmarks/results/holdout.json")


def run(arguments: argparse.Namespace, progress: Progress, say: Say) -> None:
    """Run the benchmark; leave the result and its table."""
    settings = Split(arguments.fraction, arguments.seed)
    methods = _chosen_methods(arguments.methods)
    cases = find_cases(arguments.data)
    tasks = [Task(f"{case.name}|{name}", (case, name)) for case in cases for name in methods]
    header = {
        "benchmark": "holdout",
        "settings": {"fraction": settings.fraction, "methods": _settings_of(methods)},
        "seed": settings.seed,
        "inputs": input_hashes(cases),
        "versions": versions(),
    }
    ledger = ledger_of(arguments, header)
    records = ledger.run(
        tasks, _work, lambda left: _read_all(left, settings), progress, say, "holding out"
    )
    target = arguments.output.with_suffix(".md")
    with atomic_path(target) as aside:
        aside.write_text(_markdown(settings, methods, records), encoding="utf-8")
    say(f"wrote {arguments.output} and {target}")


def _chosen_methods(wanted: Sequence[str] | None) -> list[str]:
    from brdfit.errors import UsageError
    from brdfit.reconstruct import METHODS

    known = [*METHODS, RBF]
    unknown = sorted(set(wanted or ()) - set(known))
    if unknown:
        raise UsageError(f"--methods: found {unknown[0]!r} but known are {', '.join(known)}.")
    return [name for name in known if wanted is None or name in wanted]


def _settings_of(methods: Sequence[str]) -> dict[str, Any]:
    from brdfit.reconstruct import METHODS
    from brdfit.reconstruct.result import settings_record

    described: dict[str, Any] = {
        name: settings_record(METHODS[name]()) for name in methods if name != RBF
    }
    if RBF in methods:
        described[RBF] = {"chosen_by": "five-fold cross-validation inside the fitted part"}
    return described


def _read_all(tasks: Sequence[Task], settings: Split) -> dict[str, Any]:
    cases: dict[str, RealCase] = {task.payload[0].name: task.payload[0] for task in tasks}
    return {
        "split": settings,
        "samples": {name: read_case(case) for name, case in cases.items()},
    }


def _work(shared: dict[str, Any], task: Task) -> list[Record]:
    from brdfit.reconstruct import METHODS

    case, name = task.payload
    how: Split = shared["split"]

    def fit(samples: Samples) -> tuple[Evaluate, str]:
        if name != RBF:
            return fit_method(METHODS[name](), samples)
        own_seed = int(generator(how.seed, case.name, RBF).integers(2**31))
        fitted = LogRbf.fit(samples, own_seed)
        return fitted.evaluate, fitted.settings

    record = predict_rest(case.name, shared["samples"][case.name], how, fit)
    return [{"key": task.key, "method": name, **record}]


def _markdown(settings: Split, methods: Sequence[str], records: list[Record]) -> str:
    by_case: dict[str, dict[str, Record]] = {}
    for record in records:
        by_case.setdefault(record["file"], {})[record["method"]] = record
    rows = [_row(name, found, methods) for name, found in by_case.items()]
    groups = sorted({name.split("/")[0] for name in by_case})
    for group in groups:
        inside = [found for name, found in by_case.items() if name.startswith(f"{group}/")]
        rows.append(_mean_row(f"**{group}, mean of {len(inside)}**", inside, methods))
    rows.append(_mean_row(f"**all, mean of {len(by_case)}**", list(by_case.values()), methods))
    columns = [Column("material"), *(Column(t, True) for t in ("samples", "fitted", "compared"))]
    columns += [Column("censored", True), *(Column(name, True) for name in methods)]
    return "\n".join(
        [
            "# Real files: a part fitted, the rest predicted",
            "",
            f"Made by `brdfit bench holdout`. Of each material a random "
            f"{100 * settings.fraction:g} % of the usable samples (seed {settings.seed}) is fitted "
            f"with each method's default settings; the others are predicted. A cell is the median "
            f"and the mean of |delta ln f| over the held-out values above zero, all channels "
            f"together; the lowest mean of a row is bold. Held-out values that are zero or "
            f"negative are censored: they have no logarithm, are left out, and counted in their "
            f"column. `{RBF}` is SciPy's RBF interpolator through ln f, its kernel, smoothing "
            f"and scale chosen by five-fold cross-validation inside the fitted part only.",
            "",
            table(columns, rows),
        ]
    )


def _row(name: str, found: dict[str, Record], methods: Sequence[str]) -> list[str]:
    first = next(iter(found.values()))
    compared = max(record.get("compared", 0) for record in found.values())
    censored = max(record.get("censored", 0) for record in found.values())
    counts = [str(first["samples"]), str(first["fitted"]), str(compared), str(censored)]
    return [name, *counts, *_figures(found, methods)]


def _mean_row(title: str, cases: list[dict[str, Record]], methods: Sequence[str]) -> list[str]:
    means: dict[str, Record] = {}
    for name in methods:
        whole = [found[name] for found in cases if found.get(name, {}).get("mean") is not None]
        if len(whole) == len(cases):
            means[name] = {
                part: sum(record[part] for record in whole) / len(whole)
                for part in ("median", "mean")
            }
    return [title, "", "", "", "", *_figures(means, methods)]


def _figures(found: dict[str, Record], methods: Sequence[str]) -> list[str]:
    means = {name: found.get(name, {}).get("mean") for name in methods}
    known = [mean for mean in means.values() if mean is not None]
    return [
        cell(found.get(name, {}).get("median"), means[name], bold=means[name] == min(known))
        if means[name] is not None
        else "-"
        for name in methods
    ]
