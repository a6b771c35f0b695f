"""Very many items: speed, accuracy, memory, and what is left after being killed.

    python benchmarks/batch.py --nbrdf ZIP [--parts speed,accuracy,memory,kills,dask] [-o RESULT]

The patch is mixed from the third of every three decoded networks; the population is `embedded`,
which has other fits of the same materials, or the networks of all other materials. Each part
replaces its own figures in the result and leaves the others.
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
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from batch_patch import CHUNK, Patch, random_directions

from brdfit.batch import open_batch, open_input, run_batch
from brdfit.batch.engine import Processes
from brdfit.bench.ledger import figure, versions
from brdfit.bench.markdown import Column, table
from brdfit.files import atomic_path
from brdfit.populations import Population, population
from brdfit.reconstruct import Compact, Posterior
from brdfit.reconstruct.compact import Block, CompactModel
from brdfit.samples import Samples

Record = dict[str, object]

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
            logs = np.stack(
                [np.log(CompactModel(basis, z.T).evaluate(*at)) for z in together.coefficients]
            )
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


def error(logs: np.ndarray, truth: np.ndarray) -> dict[str, float]:
    """Return mean and 90th percentile over items of the mean |delta ln f| where f > 0.001."""
    size = np.where(truth > 1e-3, np.abs(logs - np.log(np.maximum(truth, 1e-4))), np.nan)
    each = np.nanmean(size, axis=(1, 2))
    return {"mean": figure(float(each.mean())), "p90": figure(float(np.percentile(each, 90)))}


def watched(process: subprocess.Popen[bytes]) -> int:
    """Return the peak memory of a process and all below it, bytes, until it ends."""
    peak, stop = [0], threading.Event()

    def watch() -> None:
        while not stop.wait(0.1):
            peak[0] = max(peak[0], memory_of_tree(process.pid))

    thread = threading.Thread(target=watch)
    thread.start()
    process.wait()
    stop.set()
    thread.join()
    return peak[0]


def memory_of_tree(pid: int) -> int:
    """Return the proportional set size of a process and those below it, bytes."""
    total = 0
    try:
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                total += int(line.split()[1]) << 10
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return total
    return total + sum(memory_of_tree(int(child)) for child in children)


def undisturbed(words: list[str], store: Path) -> tuple[float, float]:
    """Return the seconds of a run, and those until its first block was written."""
    started, first = time.perf_counter(), None
    with subprocess.Popen(words, stdout=subprocess.DEVNULL) as process:
        while process.poll() is None:
            if first is None and blocks_of(store):
                first = time.perf_counter() - started
            time.sleep(0.01)
    assert process.returncode == 0
    assert first is not None
    return time.perf_counter() - started, first


def killed(words: list[str], store: Path, blocks: int, wait: float) -> None:
    """Kill a run so many seconds after that many blocks of its store are written."""
    with subprocess.Popen(words, stdout=subprocess.DEVNULL) as process:
        while blocks_of(store) < blocks:
            assert process.poll() is None, "the run ended before it could be killed"
            time.sleep(0.005)
        time.sleep(wait)
        process.kill()
    assert process.returncode == -signal.SIGKILL, "the run ended before it was killed"


def blocks_of(store: Path) -> int:
    """Return how many blocks of a store are marked as done."""
    return sum(1 for _ in (store / "done" / "c").glob("[0-9]*"))


def done_of(store: Path) -> int:
    """Return how many items of a store are done; 0 where there is no store yet."""
    return open_batch(store).done if store.exists() else 0


def content(store: Path) -> dict[str, bytes]:
    """Return path -> bytes of every file of a store."""
    return {str(p.relative_to(store)): p.read_bytes() for p in store.rglob("*") if p.is_file()}


def page(result: Record) -> str:
    """Return the result as a page of tables."""
    parts = result["parts"]
    blocks = [
        "# Very many items",
        "Made by `python benchmarks/batch.py`. 64 RGB samples an item, a fifth of them wrong, on a "
        "synthetic patch mixed from decoded networks; population `embedded`, default settings, "
        f"{result['cores']} cores that other work may have shared.",
    ]
    if "speed" in parts:  # type: ignore[operator]
        blocks += ["## Speed", _speed(parts["speed"])]  # type: ignore[index]
    if "accuracy" in parts:  # type: ignore[operator]
        blocks += ["## Accuracy", _accuracy(parts["accuracy"])]  # type: ignore[index]
    for name, title in (("memory", "Memory"), ("kills", "Killed and continued"), ("dask", "Dask")):
        if name in parts:  # type: ignore[operator]
            rows = [[key, json.dumps(value)] for key, value in parts[name].items()]  # type: ignore[index]
            blocks += [f"## {title}", table([Column("what"), Column("figure")], rows)]
    return "\n\n".join(blocks) + "\n"


def _speed(found: dict[str, Any]) -> str:
    two = found["workers_2"]
    rows = [
        [
            name,
            f"{found[key]['a_second']:,.1f}",
            f"{found[key]['a_core']:,.1f}",
            f"{two['a_core'] / found[key]['a_core']:,.1f}",
        ]
        for name, key in (
            (f"`run_batch`, two processes, {found['items']:,} items", "workers_2"),
            (f"`run_batch`, one process, {found['items'] // 4:,} items", "workers_1"),
            ("`Compact.fit_block`, directions shared", "core"),
            ("`Compact.fit_block`, own directions", "core_own_directions"),
            ("a loop of `Compact().fit`", "loop_of_single_fits"),
            ("a loop of `Posterior().fit`", "loop_of_posterior"),
        )
    ]
    note = (
        f"Load of the machine when it began: {found['load']:.1f} on {os.cpu_count()} cores. *A "
        "core*: items a second of processor time, all processes and their start included."
    )
    columns = [Column("who"), Column("a second", True), Column("a core", True)]
    return table([*columns, Column("ratio", True)], rows) + "\n" + note


def _accuracy(found: Record) -> str:
    rows = []
    for name in ("embedded", "other networks"):
        of = found[name]
        rows += [
            [f"{name}: {label}", f"{of[key]['mean']:.4f}", f"{of[key]['p90']:.4f}"]  # type: ignore[index]
            for label, key in (
                ("many at once", "together"),
                ("one by one", "one_by_one"),
                ("`Posterior`", "posterior"),
            )
        ]
        far = of["together_from_one_by_one"]  # type: ignore[index]
        rows.append([f"{name}: at most between the first two", f"{far:g}", ""])
    return table([Column("mean abs delta ln f"), Column("mean", True), Column("p90", True)], rows)


if __name__ == "__main__":
    main()
