"""Inverses of many small positive definite matrices, times three vectors each: three ways.

    python benchmarks/definite.py [-o benchmarks/results/definite.json]

Microseconds of processor time for one of 256 matrices, the shortest of twenty.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from array_api_compat import numpy as xp

from brdfit.bench.ledger import versions
from brdfit.files import atomic_path
from brdfit.linalg import inverse_by_halves, one_thread, solved, sweep_if_compiled

COUNT = 256


def main() -> None:
    """Measure and write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("benchmarks/results/definite.json")
    )
    arguments = parser.parse_args()
    rng, records = np.random.default_rng(0), []
    for size in (13, 33, 41, 49):
        a = rng.normal(size=(COUNT, size, 2 * size))
        a = a @ a.transpose(0, 2, 1) + np.eye(size)
        right = rng.normal(size=(COUNT, 3, size))
        ways: dict[str, Callable[[np.ndarray], object]] = {
            "numpy.linalg.inv": lambda a, r=right: r @ np.linalg.inv(a),
            "by halves": lambda a, r=right: r @ inverse_by_halves(xp, a),
        }
        if sweep_if_compiled() is not None:
            ways["compiled"] = lambda a, r=right: solved(xp, a, r)
        with one_thread():
            found = {name: round(fastest(way, a) / COUNT * 1e6, 1) for name, way in ways.items()}
        records.append({"size": size, **found})
        print(records[-1], flush=True)
    result = {"benchmark": "definite", "records": records, "versions": versions()}
    with atomic_path(arguments.output) as aside:
        aside.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def fastest(way: Callable[[np.ndarray], object], a: np.ndarray) -> float:
    """Return the shortest of twenty processor times, seconds."""
    way(a)
    found = []
    for _ in range(20):
        started = time.process_time()
        way(a)
        found.append(time.process_time() - started)
    return min(found)


if __name__ == "__main__":
    main()
