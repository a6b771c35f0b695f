"""Every population side by side as a prior, on the real files that nothing was chosen on.

    python benchmarks/populations.py --data DIR --nbrdf ZIP [-o benchmarks/results/populations.json]

A cell is the mean |delta ln f| of held-out samples (see `log_gaussian`: what is fitted, with
which prior, and which half of the files). The page goes beside the result. Errors of one
column on one file hang on the draw of the samples; means of a laboratory less.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
from log_gaussian import SETTINGS, Moments, Trial, halves, mean_error

from brdfit.bench.ledger import figure, versions
from brdfit.bench.markdown import Column, table
from brdfit.bench.real_files import input_hashes
from brdfit.files import atomic_path
from brdfit.populations import Population, population

Record = dict[str, object]


def main() -> None:
    """Measure, and leave the result and its page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of real measurements")
    parser.add_argument("--nbrdf", type=Path, required=True, help="archive of decoded networks")
    parser.add_argument("--half", choices=("reporting", "choosing"), default="reporting")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("benchmarks/results/populations.json")
    )
    arguments = parser.parse_args()
    cases = halves(arguments.data)[arguments.half]
    populations = {
        "published": population("published"),
        "nbrdf": population(arguments.nbrdf),
        "synthetic": population("synthetic"),
        "embedded": population("embedded"),
    }
    records: list[Record] = []
    for setting in SETTINGS:
        for case in cases:
            trial = Trial.of(case, setting)
            if trial is not None:
                started = time.perf_counter()
                records.append(_record(trial, populations))
                print(f"{setting}: {case.name} {time.perf_counter() - started:.1f} s", flush=True)
    result = {
        "benchmark": "populations",
        "half": arguments.half,
        "populations": {name: _facts(found) for name, found in populations.items()},
        "records": records,
        "inputs": input_hashes(cases),
        "versions": versions(),
    }
    for path, text in (
        (arguments.output, json.dumps(result, indent=1) + "\n"),
        (arguments.output.with_suffix(".md"), _page(result, records, list(populations))),
    ):
        with atomic_path(path) as aside:
            aside.write_text(text, encoding="utf-8")


def _record(trial: Trial, populations: dict[str, Population]) -> Record:
    kernels = trial.kernels()
    errors = {
        name: figure(mean_error(trial, Moments.of(found, trial), kernels))
        for name, found in populations.items()
    }
    return {"setting": str(trial.setting), "file": trial.name, **errors}


def _facts(found: Population) -> Record:
    return {
        "members": len(found),
        "columns": len(found) * len(found.channels),
        "fingerprint": found.fingerprint,
    }


def _page(result: Record, records: list[Record], names: list[str]) -> str:
    blocks = [
        "# Populations as priors, on real files",
        f"Made by `python benchmarks/populations.py --half {result['half']}`. Mean |delta ln f| of "
        "held-out samples under a Gaussian prior with the mean and covariance of a population's "
        "log-columns; *residual*: with a local Matern kernel besides; *blind*: the held-out "
        "samples come from angles of incidence, nearer to grazing, of which none was fitted. "
        "Scale, noise, amplitude and length by marginal likelihood of what is fitted; at most 600 "
        "samples predicted, at most 4 bands of a spectral file. No outliers.",
        "Of each laboratory's files in alphabetical order the first, third, ... were for choosing "
        "the shares of `embedded`; these are "
        + ("the others." if result["half"] == "reporting" else "those files."),
    ]
    facts = result["populations"]
    assert isinstance(facts, dict)
    rows = [[name, str(facts[name]["members"]), str(facts[name]["columns"])] for name in names]
    headings = [Column("population"), Column("members", True), Column("columns", True)]
    blocks.append(table(headings, rows))
    settings = list(dict.fromkeys(str(record["setting"]) for record in records))
    blocks += ["## Means", _table(_means(records, settings, names), names, "setting, files")]
    for setting in settings:
        chosen = [record for record in records if record["setting"] == setting]
        rows = [[str(record["file"]), *_row(record, names)] for record in chosen]
        blocks += [f"## {setting}", _table(rows, names, "file")]
    return "\n\n".join(blocks) + "\n"


def _means(records: list[Record], settings: list[str], names: list[str]) -> list[list[str]]:
    rows = []
    for setting in settings:
        chosen = [record for record in records if record["setting"] == setting]
        laboratories = dict.fromkeys(str(record["file"]).split("/")[0] for record in chosen)
        for laboratory in (*laboratories, ""):
            inside = [r for r in chosen if str(r["file"]).startswith(laboratory)]
            mean = {name: float(np.mean([r[name] for r in inside])) for name in names}
            label = f"{setting}, {laboratory or 'all'} ({len(inside)})"
            rows.append([f"**{label}**" if not laboratory else label, *_row(mean, names)])
            if not laboratory:
                geometric = {
                    name: float(np.exp(np.mean(np.log([r[name] for r in inside]))))
                    for name in names
                }
                rows.append([f"**{setting}, all, geometric**", *_row(geometric, names)])
    return rows


def _row(record: Record, names: list[str]) -> list[str]:
    values = [float(record[name]) for name in names]  # type: ignore[arg-type]
    return [f"**{x:.4f}**" if x == min(values) else f"{x:.4f}" for x in values]


def _table(rows: list[list[str]], names: list[str], first: str) -> str:
    return table([Column(first), *(Column(name, True) for name in names)], rows)


if __name__ == "__main__":
    main()
