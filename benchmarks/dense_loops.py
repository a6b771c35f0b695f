"""Dense RGB tables from finished fits: by numpy alone, and with the compiled loops.

    python benchmarks/dense_loops.py [-o benchmarks/results/dense_loops.json]

Milliseconds of processor time, the median of fifteen, of the table of a fit on the grid of MERL
and of the steps that have a loop; seconds of a process until every loop has run once, when
nothing is kept of an earlier one and when it is.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from brdfit.bench.ledger import versions
from brdfit.bench.speed.job import Job, Sizes
from brdfit.files import atomic_path
from brdfit.grid import MERL_GRID
from brdfit.linalg import one_thread, thin, thin_product
from brdfit.reconstruct import Compact, Posterior, slab_cells
from brdfit.versions import version_of

_FIRST = "--first"


def main() -> None:
    """Measure and write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("benchmarks/results/dense_loops.json")
    )
    parser.add_argument(_FIRST, action="store_true", help="only run every loop once, and say when")
    arguments = parser.parse_args()
    if arguments.first:
        print(first())
        return
    records: list[dict[str, Any]] = []
    for name, what in {**tables(), **steps()}.items():
        found = {"numpy": milliseconds(what, plain=True), "compiled": milliseconds(what)}
        records.append({"what": name, **found})
        print(records[-1], flush=True)
    with tempfile.TemporaryDirectory() as folder:
        kept = [first_in_own_process(Path(folder)) for _ in range(2)]
    result = {
        "benchmark": "dense_loops",
        "milliseconds": records,
        "first": {"nothing kept": kept[0], "kept": kept[1]},
        "versions": versions() | {"numba": version_of("numba")},
    }
    with atomic_path(arguments.output) as aside:
        aside.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def tables() -> dict[str, Callable[[], object]]:
    """Return what makes a table of each method."""
    job = Job("embedded", 1, Sizes(), Path())
    return {
        "table, Posterior": Posterior(population=job.others).fit(job.samples(1000)).table,
        "table, Compact": Compact(population=job.others).fit(job.items(shared=True)[0]).table,
    }


def steps() -> dict[str, Callable[[], object]]:
    """Return the steps, each as often as a table of three channels needs it."""
    rng = np.random.default_rng(0)
    h, ring = MERL_GRID.n_theta_h, MERL_GRID.size // MERL_GRID.n_theta_h

    def single(*shape: int) -> np.ndarray:
        return rng.normal(size=shape).astype(np.float32)

    rows, columns, few = single(550_000, 171), single(171, 3), single(6_000, 3)
    logs, cells, row_of = single(3, ring), single(ring, 3), np.sort(rng.integers(6_000, size=ring))
    highest, kind = np.full(ring, 30, np.float32), np.zeros((1, 90), dtype=np.int32)
    coarse, shift = single(1, 45, 36 * 3), np.zeros(180 * 3, dtype=np.float32)
    along_d, along_phi = (
        slab_cells.Between.of(np.repeat(np.eye(nodes, dtype=np.float32), times, axis=0))
        for nodes, times in ((45, 2), (36, 5))
    )
    lines = slab_cells.Lines(along_d, along_phi, single(1, 180), highest[None, :180]).each(3)

    def each(step: Callable[[], object]) -> Callable[[], object]:
        return lambda: [step() for _ in range(h)]

    return {
        "product": lambda: thin_product(rows, columns),
        "rows to cells": each(lambda: slab_cells.add_rows(logs.copy(), few, row_of, few[0])),
        "lines": each(
            lambda: slab_cells.put_lines(coarse, lines, kind, shift, cells.reshape(1, 90, -1))
        ),
        "exponentials": each(lambda: slab_cells.put_values(logs.copy(), highest, cells)),
    }


def milliseconds(what: Callable[[], object], plain: bool = False) -> float:
    """Return the median processor time of fifteen calls after one; numpy alone if `plain`."""
    found = []
    with ExitStack() as stack:
        stack.enter_context(one_thread())
        if plain:
            for module, name in ((slab_cells, "loops_if_compiled"), (thin, "_loop_if_compiled")):
                stack.enter_context(mock.patch.object(module, name, return_value=None))
        what()
        for _ in range(15):
            started = time.process_time()
            what()
            found.append(time.process_time() - started)
    return round(statistics.median(found) * 1e3, 2)


def first() -> float:
    """Run every loop once, on next to nothing; return the seconds that it took."""
    one, row = np.ones((2, 2), dtype=np.float32), np.zeros(2, dtype=np.int64)
    started = time.perf_counter()
    thin_product(one, one)
    slab_cells.add_rows(one.copy(), one, row, one[0])
    between = slab_cells.Between.of(one)
    lines = slab_cells.Lines(between, between, one, one)
    slab_cells.put_lines(one[None], lines, row[None].astype(np.int32), one[0], one[None].copy())
    slab_cells.put_values(one.copy(), one[0], one.copy())
    return round(time.perf_counter() - started, 2)


def first_in_own_process(folder: Path) -> float:
    """Return what `first` says in a process that keeps what it compiles in a folder."""
    command: list[Any] = [sys.executable, __file__, _FIRST]
    known = os.environ | {"NUMBA_CACHE_DIR": str(folder)}
    return float(subprocess.run(command, env=known, check=True, capture_output=True).stdout)


if __name__ == "__main__":
    main()
