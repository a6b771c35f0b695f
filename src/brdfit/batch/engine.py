"""Who does the work: this process, or several of this machine.

A task is two numbers, a result is what the store keeps: what travels is small, the workers
read their part of the input themselves. No more tasks are handed out than keep everybody busy.
A worker that dies takes its tasks with it; they are given to others, a few times.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Protocol

from brdfit.batch.handed import Handed
from brdfit.batch.record import PartResult
from brdfit.batch.source import BatchInput
from brdfit.errors import FitError
from brdfit.linalg import one_thread
from brdfit.reconstruct.compact import Compact, LeadingBasis

__all__ = ["RETRIES", "Engine", "Here", "Processes", "Range", "Work"]

RETRIES = 3
"""How often a task is given out again because a worker died over it."""
_AHEAD = 2  # tasks in hand for each worker
_WATCH_SECONDS = 0.5

Range = tuple[int, int, int]
"""(block, first item, item after the last)"""


@dataclass(frozen=True, eq=False)
class Work:
    """What every worker knows: input, method, basis, and the width of a name."""

    source: BatchInput
    method: Compact
    basis: LeadingBasis
    width: int

    def do(self, task: Range) -> PartResult:
        """Read a part of the input and fit it."""
        _, start, stop = task
        with one_thread():
            part = self.source.part(start, stop)
            found = None if part.block is None else self.method.fit_block(part.block, self.basis)
        shape = (len(self.source.channels), self.basis.size)
        return PartResult.of(start, part, found, shape, self.width)


class Engine(Protocol):
    """Runs tasks in any order."""

    def run(self, work: Work, tasks: Sequence[Range]) -> Iterator[tuple[int, PartResult]]:
        """Yield (block, result) of every task as it finishes."""


@dataclass(frozen=True)
class Here:
    """The process that asks, one task after the other."""

    def run(self, work: Work, tasks: Sequence[Range]) -> Iterator[tuple[int, PartResult]]:
        """Yield (block, result) of every task, in order."""
        for task in tasks:
            yield task[0], work.do(task)


@dataclass(frozen=True)
class Processes:
    """Several processes of this machine, each with one thread of linear algebra."""

    workers: int

    def run(self, work: Work, tasks: Sequence[Range]) -> Iterator[tuple[int, PartResult]]:
        """Yield (block, result) of every task as it finishes.

        Raises `FitError` where workers keep dying over the same task.
        """
        left = list(reversed(tasks))
        tries: dict[Range, int] = {}
        while left:
            held: dict[Future[PartResult], Range] = {}
            with Handed(work) as handed, _pool(self.workers, handed) as pool:
                try:
                    yield from _served(pool, left, held, tries, _AHEAD * self.workers)
                except BrokenProcessPool as error:
                    lost = list(held.values())
                    for task in lost:
                        tries[task] = tries.get(task, 0) + 1
                        if tries[task] > RETRIES:
                            raise FitError(
                                f"a worker died {tries[task]} times over items {task[1]} to "
                                f"{task[2] - 1} (killed, or out of memory). What is finished is "
                                f"kept: repeat the command with fewer --workers, or less --memory."
                            ) from error
                    left += reversed(lost)


def _served(
    pool: ProcessPoolExecutor,
    left: list[Range],
    held: dict[Future[PartResult], Range],
    tries: dict[Range, int],
    most: int,
) -> Iterator[tuple[int, PartResult]]:
    """Hand out tasks from the end of `left`, `most` at a time, and yield what comes back.

    One over which a worker may have died is tried alone: it is known then whose fault it was.
    """

    def may_hand_out() -> bool:
        if not left or any(task in tries for task in held.values()):
            return False
        return not held if left[-1] in tries else len(held) < most

    while left or held:
        while may_hand_out():
            task = left.pop()
            try:
                held[pool.submit(_do, task)] = task
            except BrokenProcessPool:
                left.append(task)
                raise
        finished, _ = wait(held, return_when=FIRST_COMPLETED)
        for future in finished:
            result = future.result()
            yield held.pop(future)[0], result


class _pool:  # noqa: N801 - reads as the context manager that it is
    """A pool of workers that are ended, however the block is left.

    Spawned, not forked: a fork beside the threads of Arrow and Zarr may inherit a held lock.
    """

    def __init__(self, workers: int, work: Handed) -> None:
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(workers, context, _adopt, (work, os.getpid()))

    def __enter__(self) -> ProcessPoolExecutor:
        return self._pool

    def __exit__(self, kind: object, *_: object) -> None:
        if kind is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)


# What this worker was started with; set once per process by `_adopt`.
_ADOPTED: list[Work] = []


def _adopt(work: Handed, parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _ADOPTED[:] = [work.value]
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    """End this process when the one that started it is gone, however it went."""
    while os.getppid() == parent:
        time.sleep(_WATCH_SECONDS)
    os._exit(1)


def _do(task: Range) -> PartResult:
    return _ADOPTED[0].do(task)
