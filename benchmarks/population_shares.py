"""Choose what each synthetic family counts beside the published fits, on half of the real files.

    python benchmarks/population_shares.py --data DIR [-o RESULT.json]

One family after the other has its share tripled or cut to a third, from LEAST to MOST, and the
change is kept where the error falls by more than WORTH: the geometric mean, over settings, files
and draws of the samples, of the mean |delta ln f| of held-out samples (see `log_gaussian`). The
k files of a laboratory count sqrt(k) together: thirty of one instrument are not thirty opinions.
Repeated until nothing changes. The files for reporting are not read. What was found is not used
by itself: it stands, by hand, in `brdfit.populations.embedded`.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
from log_gaussian import Moments, Setting, Trial, halves, mean_error

from brdfit.bench.ledger import figure, versions
from brdfit.bench.real_files import input_hashes
from brdfit.files import atomic_path
from brdfit.populations import Population, population

SETTINGS = (
    Setting(100),
    Setting(300),
    Setting(100, residual=True),
    Setting(100, residual=True, blind=True),
)
START = 0.1
FACTORS = (3.0, 1.0 / 3.0)
# What is not among the files for choosing stays possible.
LEAST = 0.01
# No family counts more than the published fits of a hundred materials.
MOST = 1.0
WORTH = 2e-3
ROUNDS = 5
DRAWS = 3


def main() -> None:
    """Choose, print, and write the result where it is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of real measurements")
    parser.add_argument("--half", choices=("choosing", "reporting"), default="choosing")
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    cases = halves(arguments.data)[arguments.half]
    parts = families()
    objective = _objective(cases, list(parts.values()))
    shares, history = search(objective, list(parts))
    result = {
        "half": arguments.half,
        "settings": [str(setting) for setting in SETTINGS],
        "shares": shares,
        "history": history,
        "fingerprints": {part.name: part.fingerprint for part in parts.values()},
        "inputs": input_hashes(cases),
        "files": [case.name for case in cases],
        "versions": versions(),
    }
    text = json.dumps(result, indent=1) + "\n"
    print(text, end="")
    if arguments.output:
        with atomic_path(arguments.output) as aside:
            aside.write_text(text, encoding="utf-8")


def families() -> dict[str, Population]:
    """Return the published fits and each synthetic family, by name."""
    synthetic = population("synthetic")
    found = {"published": population("published")}
    return found | {name: synthetic.subset([name]) for name in synthetic.unique_materials}


def _objective(cases: list, parts: list[Population]) -> Callable[[list[float]], float]:
    trials = [
        trial
        for setting in SETTINGS
        for case in cases
        for draw in range(DRAWS)
        if (trial := Trial.of(case, setting, draw)) is not None
    ]
    moments = [[Moments.of(part, trial) for part in parts] for trial in trials]
    kernels = [trial.kernels() for trial in trials]
    laboratories = Counter((trial.laboratory, trial.setting) for trial in trials)
    counts = [laboratories[trial.laboratory, trial.setting] ** -0.5 for trial in trials]

    def error(shares: list[float]) -> float:
        logs = [
            np.log(mean_error(trial, Moments.mixed(of_parts, shares), local))
            for trial, of_parts, local in zip(trials, moments, kernels, strict=True)
        ]
        return float(np.exp(np.average(logs, weights=counts)))

    return error


def search(
    objective: Callable[[list[float]], float], names: list[str]
) -> tuple[dict[str, float], list[dict[str, object]]]:
    """Return the shares found (the published fits count 1), and every step on the way."""
    shares = [1.0] + [START] * (len(names) - 1)
    alone = [1.0] + [0.0] * (len(names) - 1)
    best = objective(shares)
    history: list[dict[str, object]] = [
        {"changed": "only the published fits", "error": figure(objective(alone))},
        {"changed": f"every family counts {START}", "error": figure(best)},
    ]
    for _ in range(ROUNDS):
        before = best
        for k in range(1, len(names)):
            tried = {}
            for factor in FACTORS:
                changed = [*shares[:k], min(max(shares[k] * factor, LEAST), MOST), *shares[k + 1 :]]
                tried[factor] = (objective(changed), changed)
            error, changed = min(tried.values(), key=lambda item: item[0])
            if error < best * (1.0 - WORTH):
                best, shares = error, changed
                step = f"{names[k]} to {shares[k]:.3g}"
                history.append({"changed": step, "error": figure(best)})
                print(step, f"{best:.5f}", flush=True)
        if best == before:
            break
    return {name: round(share, 3) for name, share in zip(names, shares, strict=True)}, history


if __name__ == "__main__":
    main()
