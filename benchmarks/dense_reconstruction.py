"""Time one dense reconstruction from 10 % of the grid, the correction basis in memory.

    python benchmarks/dense_reconstruction.py POPULATION [-o RESULT.json]

One material of the population is left out, 110,000 of its cells are the measurements (three
channels, 40 % `factor` outliers), and the complete table is made: the fit, which touches the
basis at the samples only, and the one product over all cells. What stays in memory between
reconstructions (members and correction functions at every cell) is not counted. Beside it, in
the same run, SciPy's RBF interpolator (64 neighbours) through the same samples: timed on a
twentieth of the cells and multiplied, since nobody would wait for all of them.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import brdfit
from brdfit.bench.ledger import versions
from brdfit.bench.outliers import contaminate
from brdfit.files import atomic_path
from brdfit.grid import MERL_GRID
from brdfit.populations import columns
from brdfit.reconstruct.correction_basis import correction_basis
from brdfit.reconstruct.correction_functions import CorrectedCombination
from brdfit.reconstruct.members import MemberRows
from brdfit.reconstruct.tabulated import half_diff_features
from brdfit.reconstruct.targets import Targets
from brdfit.transform import error_metric

SAMPLES = 110_000
OUTLIERS = 0.4
RBF_SHARE = 20
SEED = 1


def main() -> None:
    """Measure, print, and write the result where it is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("population", help="a name, an archive of networks, a folder of tables")
    parser.add_argument("--material", default="", help="left out and reconstructed; default: first")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    result = measure(arguments.population, arguments.material, arguments.repeat)
    text = json.dumps(result, indent=1, sort_keys=True) + "\n"
    print(text, end="")
    if arguments.output:
        with atomic_path(arguments.output) as aside:
            aside.write_text(text, encoding="utf-8")


def measure(name: str, material: str, repeat: int) -> dict[str, object]:
    """Return the figures of one run, seconds."""
    everything = brdfit.population(name)
    material = material or everything.unique_materials[0]
    others = everything.without([material])
    method = brdfit.CorrectionFunctions(population=others)
    rng = np.random.default_rng(SEED)
    rows = np.sort(rng.choice(MERL_GRID.cells.size, SAMPLES, replace=False))
    wi, wo = MERL_GRID.directions(MERL_GRID.cells[rows])
    truth = np.maximum(everything.subset([material]).evaluate(wi, wo)[:, 0], 1e-4)
    values = contaminate("factor", truth.astype(np.float64), OUTLIERS, rng).values
    samples = brdfit.Samples(wi=wi, wo=wo, value=values)

    basis = correction_basis(others, error_metric(method.error_metric), lambda *_: None)
    dense = columns(others)
    cells = MemberRows.read(dense, 0, len(dense))
    at_cells = basis.evaluate(cells)
    at = dense.expand[rows]
    roles, targets = np.arange(samples.n_channels), Targets.of(samples)

    def fit() -> CorrectedCombination:
        members = cells.take(at)
        combination, loop = method.fit_rows(members, targets, roles, basis, at_cells[at])
        return CorrectedCombination(others, combination, basis, loop.corrections)

    def table(model: CorrectedCombination) -> np.ndarray:
        return np.exp(model.log_value(cells, at_cells))[dense.expand]

    model = fit()
    fitting, filling = _times(fit, repeat), _times(lambda: table(model), repeat)
    rbf = _rbf_seconds(samples)
    total = statistics.median(fitting) + statistics.median(filling)
    return {
        "what": f"{SAMPLES} samples, 3 channels, {OUTLIERS:.0%} outliers, without {material}",
        "cells": int(MERL_GRID.cells.size),
        "fit_seconds": fitting,
        "dense_seconds": filling,
        "median_total_seconds": total,
        "rbf_seconds_extrapolated": rbf,
        "rbf_over_ours": rbf / total,
        "versions": versions(),
    }


def _times(work: Callable[[], object], repeat: int) -> list[float]:
    found = []
    for _ in range(repeat):
        start = time.perf_counter()
        work()
        found.append(round(time.perf_counter() - start, 3))
    return found


def _rbf_seconds(samples: brdfit.Samples) -> float:
    start = time.perf_counter()
    features = half_diff_features(*samples.half_diff)
    interpolator = brdfit.Tabulated().interpolator(features, samples.value)
    built = time.perf_counter() - start
    some = MERL_GRID.cells[::RBF_SHARE]
    start = time.perf_counter()
    interpolator(half_diff_features(*MERL_GRID.half_diff(some)))
    return built + RBF_SHARE * (time.perf_counter() - start)


if __name__ == "__main__":
    main()
