"""Very many items: speed, accuracy, memory, and what is left after being killed.

    python benchmarks/batch.py --nbrdf ZIP [--parts speed,memory,...] [-o RESULT]

The patch is mixed from the third of every three decoded networks; the population is `embedded`,
which has other fits of the same materials, or the networks of all other materials. Each part
replaces its own figures in the result and leaves the others; the part torch wants PyTorch.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from batch_page import page
from batch_patch import CHUNK, Patch, random_directions
from batch_processes import blocks_of, content, done_of, killed, undisturbed, watched

from brdfit.batch import open_input, run_batch
from brdfit.batch.engine import Processes
from brdfit.bench.ledger import figure, versions
from brdfit.files import atomic_path
from brdfit.populations import Population, population
from brdfit.reconstruct import Compact, Posterior
from brdfit.reconstruct.compact import Block, BlockResult, CompactModel, LeadingBasis
from brdfit.samples import Samples

Record = dict[str, object]
Pairs = tuple[np.ndarray, np.ndarray]

_KILLS, _AT_START = 20, 5


def main() -> None:
    """Measure the parts that were asked for; write the result and its page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nbrdf", type=Path, required=True, help="archive of decoded networks")
    parser.add_argument("--parts", default="speed,accuracy,memory,kills,dask")
    parser.add_argument("--items", type=int, default=100_000)
    parser.add_argument(
        "--memory-items",
        default="10000,300000,1000000",
        help="sizes of the part memory; the longest takes minutes and 2 GB of disk",
    )
    parser.add_argument("-o", "--output", type=Path, default=Path("benchmarks/results/batch.json"))
    arguments = parser.parse_args()
    networks = population(arguments.nbrdf)
    used = networks.unique_materials[2::3]
    sizes = tuple(int(size) for size in arguments.memory_items.split(","))
    bench = Bench(networks, used, arguments.items, sizes)
    result: Record = {"benchmark": "batch", "parts": {}}
    if arguments.output.exists():
        result = json.loads(arguments.output.read_text())
    for part in arguments.parts.split(","):
        print(part, flush=True)
        found = getattr(bench, part)()
        result["parts"][part] = found  # type: ignore[index]
        print(json.dumps(found, indent=1), flush=True)
    result |= {"materials": list(used), "versions": versions(), "cores": os.cpu_count()}
    for path, text in (
        (arguments.output, json.dumps(result, indent=1) + "\n"),
        (arguments.output.with_suffix(".md"), page(result)),
    ):
        with atomic_path(path) as aside:
            aside.write_text(text, encoding="utf-8")


class Bench:
    """The parts, each a function that returns its figures."""

    def __init__(
        self, networks: Population, used: tuple[str, ...], items: int, sizes: tuple[int, ...]
    ) -> None:
        self.networks = networks
        self.used = used
        self.items = items
        self.sizes = sizes
        self._scratch = tempfile.TemporaryDirectory(prefix="batch-")
        self.folder = Path(self._scratch.name)

    def patch(self, count: int) -> Patch:
        """Return a patch of `count` points."""
        return Patch(self.networks.subset(self.used), count)

    def table(self, count: int) -> Path:
        """Return a long table of `count` points, written once."""
        path = self.folder / f"{count}.parquet"
        return path if path.exists() else self.patch(count).write(path)

    def speed(self) -> Record:
        """Items a second, and a second of processor time: a busy machine spoils the first."""
        method, found = Compact(), {"items": self.items, "load": os.getloadavg()[0]}
        basis, path = method.basis(), self.table(self.items)
        for workers in (2, 1):
            count = self.items if workers == 2 else self.items // 4
            store = self.folder / "speed.zarr"
            took = Took.by(lambda c=count, s=store, w=workers: timed_run(self.table(c), s, w))
            found[f"workers_{workers}"] = took.rates(count)
        part = open_input(path).part(0, 4 * CHUNK)
        own = Block.of(self.patch(CHUNK).scattered(CHUNK))
        for name, block in (("core", part.block), ("core_own_directions", own)):
            took = min(Took.by(lambda b=block: method.fit_block(b, basis)) for _ in range(3))
            found[name] = took.rates(len(block))
        singles = [self.patch(self.items).item(point * 611) for point in range(24)]
        found["loop_of_single_fits"] = Took.by(lambda: loop(method, singles)).rates(24)
        published = Posterior(population="embedded")
        published.fit(singles[0])
        found["loop_of_posterior"] = Took.by(lambda: loop(published, singles[:8])).rates(8)
        return found

    def accuracy(self) -> Record:
        """Mean |delta ln f| at other directions: together, one by one, and `Posterior`."""
        patch, at = self.patch(self.items), random_directions(500, 4)
        points = np.linspace(0, self.items - 1, 40).astype(int)
        truth = patch.truth(points, *at)
        found: Record = {"items": len(points), "directions": 500}
        populations = {
            "embedded": population("embedded"),
            "other networks": self.networks.without(self.used),
        }
        items = [patch.item(int(point)) for point in points]
        for name, materials in populations.items():
            method = Compact(population=materials)
            basis = method.basis()
            together = method.fit_block(Block.of(items), basis)
            logs = logs_of(together, basis, at)
            alone = np.stack([np.log(method.fit(item).evaluate(*at)) for item in items])
            published = Posterior(population=materials)
            slow = np.stack([np.log(published.fit(item).evaluate(*at)) for item in items])
            found[name] = {
                "together": error(logs, truth),
                "one_by_one": error(alone, truth),
                "posterior": error(slow, truth),
                "together_from_one_by_one": float(f"{np.abs(logs - alone).max():.2g}"),
            }
        return found

    def memory(self) -> Record:
        """Peak of the memory of all processes together, two workers, by number of items."""
        found: Record = {"limit_mb": 1024, "workers": 2}
        for count in self.sizes:
            words = [sys.executable, "-m", "brdfit", "batch", str(self.table(count)), "-o"]
            store = self.folder / f"m{count}.zarr"
            words += [str(store), "--workers", "2", "--memory", "1GB"]
            started = time.perf_counter()
            with subprocess.Popen(words, stdout=subprocess.DEVNULL) as process:
                peak = watched(process)
            assert process.returncode == 0
            seconds = time.perf_counter() - started
            found[str(count)] = {"peak_mb": peak >> 20, "seconds": round(seconds, 1)}
            print(count, found[str(count)], flush=True)
            (self.folder / f"{count}.parquet").unlink()
            shutil.rmtree(store)
        return found

    def dask(self) -> Record:
        """Items a second, once they run, of one and two Dask workers; one killed in the middle."""
        from brdfit.batch.cluster import Cluster

        table, found = self.table(self.items // 4), {"items": self.items // 4}
        for workers in (1, 2):
            with Cluster(workers=workers) as engine:
                rate = steady_rate(table, self.folder / f"dask{workers}.zarr", engine)
            found[f"workers_{workers}"] = figure(rate)
        found["ratio"] = figure(found["workers_2"] / found["workers_1"])
        with Cluster(workers=2) as engine:
            run = Killing(engine, after=3)
            timed_run(table, self.folder / "killed.zarr", 2, run)
        found["killed_worker"] = run.killed
        found["identical"] = content(self.folder / "killed.zarr") == content(
            self.folder / "dask2.zarr"
        )
        return found

    def torch(self) -> Record:
        """Items a second of processor time with PyTorch's arrays, and how far from numpy's."""
        import torch

        torch.set_num_threads(1)
        method, at = Compact(), random_directions(200, 5)
        basis = method.basis()
        shared = open_input(self.table(CHUNK)).part(0, CHUNK).block
        own = Block.of(self.patch(CHUNK).scattered(CHUNK))
        found: Record = {"version": str(torch.__version__), "items": CHUNK, "blocks": {}}
        for name, block in (("directions shared", shared), ("directions of their own", own)):
            rates, logs = {}, {}
            for library, to in (("numpy", None), ("torch", torch.from_numpy)):
                fits: list[BlockResult] = []
                took = min(
                    Took.by(lambda t=to, b=block, f=fits: f.append(method.fit_block(b, basis, t)))
                    for _ in range(3)
                )
                rates[library] = took.rates(len(block))["a_core"]
                logs[library] = logs_of(fits[-1], basis, at)
            apart = np.abs(logs["torch"] - logs["numpy"]).max()
            found["blocks"][name] = rates | {"most_apart": float(f"{apart:.2g}")}  # type: ignore[index]
        return found

    def kills(self) -> Record:
        """Kill a run at random moments, continue it, and compare with an undisturbed one.

        Twenty times between its first block and its last, evenly drawn, each once a block more
        is written; before that a few times while it starts.
        """
        path, chance = self.table(self.items), random.Random(20)
        whole, pieces = self.folder / "whole.zarr", self.folder / "pieces.zarr"
        words = [sys.executable, "-m", "brdfit", "batch", str(path), "--workers", "2", "-o"]
        Compact().fit(self.patch(CHUNK).item(0))  # what is compiled or built once is there then
        seconds, first = undisturbed([*words, str(whole)], whole)
        blocks = blocks_of(whole)
        pace = (seconds - first) / blocks
        for _ in range(_AT_START):
            killed([*words, str(pieces)], pieces, 0, chance.uniform(0.0, first))
        started = done_of(pieces)
        done: list[int] = []
        for mark in sorted(chance.sample(range(1, blocks - 1), _KILLS)):
            before = blocks_of(pieces)
            killed([*words, str(pieces)], pieces, max(mark, before + 1), chance.uniform(0.0, pace))
            done.append(done_of(pieces))
        subprocess.run([*words, str(pieces)], check=True, stdout=subprocess.DEVNULL)
        return {
            "items": self.items,
            "blocks": blocks,
            "kills_while_starting": _AT_START,
            "done_after_those": started,
            "kills": len(done),
            "done_after_each": done,
            "identical": content(whole) == content(pieces),
        }


class Killing:
    """An engine of Dask that loses a worker after some blocks."""

    def __init__(self, engine: Any, after: int) -> None:
        self.engine, self.after, self.killed = engine, after, ""

    def run(self, work: Any, tasks: Any) -> Any:
        """Yield what the engine yields; kill once."""
        for number, result in enumerate(self.engine.run(work, tasks)):
            yield result
            if number == self.after:
                workers = self.engine.client.run(os.getpid)
                self.killed, pid = next(iter(workers.items()))
                os.kill(pid, signal.SIGKILL)


def timed_run(path: Path, store: Path, workers: int, engine: Any = None) -> float:
    """Return the seconds of a run, from the first item handed out to the last one written."""
    shutil.rmtree(store, ignore_errors=True)
    begun: list[float] = []

    def note(label: str, done: int, total: int) -> None:
        if label == "items":
            begun.append(time.perf_counter())

    engine = engine or Processes(workers)
    run_batch(open_input(path), store, engine=engine, workers=workers, block=1024, progress=note)
    return begun[-1] - begun[0]


def steady_rate(path: Path, store: Path, engine: Any) -> float:
    """Return items a second from the first block that is written to the last."""
    shutil.rmtree(store, ignore_errors=True)
    told: list[tuple[float, int]] = []

    def note(label: str, done: int, total: int) -> None:
        if label == "items":
            told.append((time.perf_counter(), done))

    run_batch(open_input(path), store, engine=engine, block=1024, progress=note)
    (begun, first), (ended, last) = told[1], told[-1]
    return (last - first) / (ended - begun)


@dataclass(frozen=True, order=True)
class Took:
    """What work took: of the processor, its workers included, and by the clock."""

    processor: float
    seconds: float

    @classmethod
    def by(cls, what: Callable[[], object]) -> Took:
        """Return what calling `what` takes; if it returns a float, that is the time."""
        before, started = processor_time(), time.perf_counter()
        own = what()
        seconds = own if isinstance(own, float) else time.perf_counter() - started
        return cls(processor_time() - before, seconds)

    def rates(self, count: int) -> dict[str, float]:
        """Return items a second and items a second of the processor."""
        return {"a_second": figure(count / self.seconds), "a_core": figure(count / self.processor)}


def processor_time() -> float:
    """Return seconds of processor time of this process and of its children that ended."""
    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(use.ru_utime + use.ru_stime for use in map(resource.getrusage, who))


def loop(method: Compact | Posterior, items: list[Samples]) -> None:
    """Fit one after the other."""
    for item in items:
        method.fit(item)


def logs_of(fits: BlockResult, basis: LeadingBasis, at: Pairs) -> np.ndarray:
    """Return ln f_r (items, n, c) of the fits of a block at directions."""
    return np.stack([np.log(CompactModel(basis, z.T).evaluate(*at)) for z in fits.coefficients])


def error(logs: np.ndarray, truth: np.ndarray) -> dict[str, float]:
    """Return mean and 90th percentile over items of the mean |delta ln f| where f > 0.001."""
    size = np.where(truth > 1e-3, np.abs(logs - np.log(np.maximum(truth, 1e-4))), np.nan)
    each = np.nanmean(size, axis=(1, 2))
    return {"mean": figure(float(each.mean())), "p90": figure(float(np.percentile(each, 90)))}


if __name__ == "__main__":
    main()
