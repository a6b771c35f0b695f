"""A small batch: a population of ten members, and a long table of items mixed from others.

Also a program, for the tests that kill it: python small_batch.py TABLE STORE [WORKERS | dask]
"""

from __future__ import annotations

import os
import signal
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.batch import open_input, run_batch
from brdfit.batch.engine import Here, Processes
from brdfit.geometry import directions_from_spherical
from brdfit.populations import population
from brdfit.reconstruct import Compact

N_SAMPLES = 24
BLOCK = 64


def members(start):
    """Return the published fits of every tenth material, from `start` on."""
    published = population("published")
    return published.subset(published.unique_materials[start::10])


def method():
    """Return the method of these tests."""
    return Compact(population=members(0), components=12, steps=6)


def columns(items, shared=True, seed=0):
    """Return the columns of a long table of items, one sample in six wrong."""
    rng = np.random.default_rng(seed)
    n = N_SAMPLES * (1 if shared else items)
    theta, phi = np.arccos(rng.uniform(0.2, 1.0, (2, n))), rng.uniform(-np.pi, np.pi, (2, n))
    wi, wo = directions_from_spherical(theta, phi)
    values = members(5).evaluate(wi, wo).astype(np.float64)
    if shared:
        wi, wo = np.tile(wi, (items, 1)), np.tile(wo, (items, 1))
    which = np.repeat(rng.integers(0, values.shape[1], items), N_SAMPLES)
    row = np.tile(np.arange(N_SAMPLES), items) if shared else np.arange(n)
    value = values[row, which] * np.exp(0.02 * rng.normal(size=(len(row), 3)))
    wrong = rng.random(len(row)) < 1 / 6
    value[wrong] *= np.exp(rng.uniform(-2.0, 2.0, (int(wrong.sum()), 1)))
    item = np.repeat(np.arange(items), N_SAMPLES)
    named = {"item": item, "x": item % 16, "y": item // 16}
    for label, w in (("wi", wi), ("wo", wo)):
        named |= {f"{label}_{axis}": w[:, place] for place, axis in enumerate("xyz")}
    return named | {channel: value[:, place] for place, channel in enumerate("RGB")}


def write_parquet(path, named, rows=1000):
    """Write columns as Parquet, in row groups that end in the middle of items."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table(named), path, row_group_size=rows)
    return path


def write_zarr(path, named):
    """Write columns as a Zarr group."""
    import zarr

    group = zarr.create_group(str(path))
    for name, column in named.items():
        group.create_array(name, data=np.asarray(column), chunks=(700,))
    return path


@dataclass(frozen=True, eq=False)
class Deadly:
    """An input that kills whoever reads one part of it."""

    inner: Any

    def __getattr__(self, what):
        if what.startswith("__") or what == "inner":
            raise AttributeError(what)
        return getattr(self.inner, what)

    def part(self, start, stop):
        if start == 2 * BLOCK:
            os._exit(9)
        return self.inner.part(start, stop)


def content(store):
    """Return path -> bytes of every file of a store."""
    store = Path(store)
    return {p.relative_to(store): p.read_bytes() for p in store.rglob("*") if p.is_file()}


def main() -> None:
    table, store = sys.argv[1:3]
    workers = sys.argv[3] if len(sys.argv) > 3 else "1"
    if workers == "dask":
        run_on_dask_and_kill_a_worker(table, store)
        return
    engine = Here() if workers == "1" else Processes(int(workers))
    run_batch(open_input(table), store, method(), engine=engine, block=BLOCK)


def run_on_dask_and_kill_a_worker(table, store) -> None:
    """Run with two workers of Dask, the first of which is killed after three blocks."""
    from brdfit.batch.cluster import Cluster

    with Cluster(workers=2) as engine:
        workers = engine.client.run(os.getpid)
        told = []

        def kill_once(result):
            told.append(result.start)
            if len(told) == 3:
                os.kill(next(iter(workers.values())), signal.SIGKILL)

        run_batch(open_input(table), store, method(), engine=engine, block=BLOCK, told=kill_once)
        print(len(told), len(set(told)))


if __name__ == "__main__":
    main()
