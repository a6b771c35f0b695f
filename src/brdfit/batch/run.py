"""A run of a batch: begin a store or continue it, block by block, under a limit of memory."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from brdfit.batch.engine import Engine, Here, Range, Work
from brdfit.batch.record import PartResult
from brdfit.batch.source import BatchInput
from brdfit.batch.store import BatchStore, Facts
from brdfit.errors import UsageError
from brdfit.files import sha256_of_bytes
from brdfit.linalg import sweep_if_compiled
from brdfit.populations import cache_folder
from brdfit.progress import Progress, silent
from brdfit.reconstruct.compact import Compact, LeadingBasis
from brdfit.reconstruct.result import settings_record
from brdfit.versions import versions_of

__all__ = ["MEMORY", "RunSummary", "items_of_a_block", "run_batch"]

MEMORY = 1 << 30
"""Bytes that a run may take in all, unless told otherwise."""
# Of a process before it has read anything: the interpreter, numpy, pyarrow, the basis.
_BASE = 170 << 20
# Copies of a sample that are held at once, as numbers of 8 bytes a column; what solving holds.
_COPIES, _SOLVING = 10, 60 << 20
_MOST, _STEP = 2048, 64
_LABEL = "items"


@dataclass(frozen=True)
class RunSummary:
    """What a run did."""

    store: Path
    items: int
    """Items of the store."""
    fitted: int
    """Items of this run, failures included."""
    failed: tuple[tuple[str, str], ...]
    """(name, why) of the first of this run that could not be fitted."""
    failures: int
    continued: bool
    """Whether the store was there before."""
    outcomes: dict[str, int]
    """How many items of the store ended how, those that failed as "failed"."""
    example: str
    """Name of the first item that has a result; empty without one."""


def items_of_a_block(source: BatchInput, memory: int, workers: int) -> int:
    """Return how many items a worker may hold, a multiple of 64 where there are so many.

    Raises `UsageError` where not even one fits.
    """
    per_item = source.samples_per_item * (8 + 3 * len(source.channels)) * 8 * _COPIES
    room = memory / (workers + 1) - _BASE - _SOLVING
    items = max(int(room / per_item), 0)
    if items < 1:
        need = int((workers + 1) * (_BASE + _SOLVING + per_item) / (1 << 20)) + 1
        raise UsageError(
            f"memory: {memory >> 20} MB are too little for {workers} workers and items of "
            f"{source.samples_per_item:.0f} samples; give {need} MB, or fewer workers."
        )
    return min(items // _STEP * _STEP if items > _STEP else items, _MOST)


def run_batch(
    source: BatchInput,
    output: str | Path,
    method: Compact | None = None,
    *,
    engine: Engine | None = None,
    workers: int = 1,
    memory: int = MEMORY,
    block: int | None = None,
    restart: bool = False,
    progress: Progress = silent,
    told: Callable[[PartResult], None] | None = None,
) -> RunSummary:
    """Fit every item of `source` and keep the results at `output`; continue what is there.

    Parameters
    ----------
    source
        What `open_input` returns.
    output
        Folder of the store, by custom *.zarr. One with the same input, settings and versions is
        continued; any other is refused unless `restart`.
    method
        Settings; left out, `Compact()`.
    engine
        Who does the work (`Here`, `Processes`, `cluster.Cluster`); left out, this process.
    workers, memory
        How many there are, and the bytes that all may take together: they decide how many
        items are held at once when a store is begun.
    block
        So many, in place of what memory allows.
    progress, told
        Hear of items done, and of every block.

    Raises `UsageError` where the output holds something else or memory is too short,
    `PopulationError` where the population cannot be had.
    """
    method = Compact() if method is None else method
    basis = method.basis(progress)
    path = Path(output)
    with _alone(path):
        block = block or items_of_a_block(source, memory, workers)
        store, continued = _store(path, source, method, basis, block, restart)
        store.clear_remains()
        tasks: list[Range] = [(int(number), *store.rows(number)) for number in store.missing()]
        done = store.count - sum(stop - start for _, start, stop in tasks)
        before = done
        failed: list[tuple[str, str]] = []
        failures = 0
        progress(_LABEL, done, store.count)
        work = Work(source, method, basis, int(store.attributes["width"]))
        for number, result in (engine or Here()).run(work, tasks):
            store.put(number, result)
            done += len(result)
            for problem in result.failed:
                failures += 1
                if len(failed) < 20:
                    failed.append(problem)
            progress(_LABEL, done, store.count)
            if told is not None:
                told(result)
    outcomes, example = store.outcomes()
    return RunSummary(
        path, store.count, done - before, tuple(failed), failures, continued, outcomes, example
    )


def _store(
    path: Path,
    source: BatchInput,
    method: Compact,
    basis: LeadingBasis,
    block: int,
    restart: bool,
) -> tuple[BatchStore, bool]:
    facts = Facts(
        count=source.count,
        block=block,
        width=max(source.longest_name, 1),
        channels=source.channels,
        wavelengths=source.wavelengths,
        taken_from={"name": source.name, "sha256": source.fingerprint()},
        method=settings_record(method),
        population=dict(basis.population),
        versions=_versions(),
    )
    if path.exists() and not restart:
        store = BatchStore.open(path, "r+")
        different = store.differences(facts, basis)
        if different:
            raise UsageError(
                f"{path}: holds another batch and is not continued. What differs: "
                f"{'; '.join(different)}. Name another output, or begin anew with --restart."
            )
        return store, True
    if path.exists():
        BatchStore.open(path)  # only what a batch wrote is removed
        shutil.rmtree(path)
    return BatchStore.create(path, facts, basis), False


def _versions() -> dict[str, str]:
    # How small matrices are inverted makes a difference in the last bits.
    inverses = "numpy" if sweep_if_compiled() is None else "compiled"
    return versions_of("brdfit", "numpy", "zarr") | {"inverses": inverses}


class _alone:  # noqa: N801 - reads as the context manager that it is
    """Keep a second run away from the same store."""

    def __init__(self, path: Path) -> None:
        from filelock import FileLock

        self._path = path
        name = sha256_of_bytes(str(path.resolve()).encode())[:24]
        self._lock = FileLock(cache_folder("batch-locks") / f"{name}.lock")

    def __enter__(self) -> None:
        from filelock import Timeout

        try:
            self._lock.acquire(timeout=0)
        except Timeout:
            raise UsageError(f"{self._path}: another brdfit batch is writing it.") from None

    def __exit__(self, *_: object) -> None:
        self._lock.release()
