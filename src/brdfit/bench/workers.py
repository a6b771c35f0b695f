"""Tasks over processes: both cores busy, results as they come, nobody left behind.

Workers are forked where the system can do that (what was prepared is then shared memory,
not copied) and spawned elsewhere. They ignore Ctrl-C, which is for the parent to answer, and
end themselves when the parent is gone, however it went.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from brdfit.errors import BrdfitError

__all__ = ["Task", "Work", "in_own_process", "limit_threads", "run_pool"]

_WATCH_SECONDS = 0.5
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Task:
    """One part of a run: a stable key and what the worker needs to know."""

    key: str
    payload: Any = None
    cost: int = 1
    """How long it takes beside the others, for the estimate of time left."""


Work = Callable[[Any, Task], list[dict[str, Any]]]
"""`work(shared, task)` returns the records of the task; a function of a module."""


def limit_threads() -> None:
    """Ask the linear algebra for one thread a process: the processes are the parallelism.

    Works before numpy is imported for the first time, so that the command line calls it
    ahead of everything else; a user's own setting stays.
    """
    for name in _THREADS:
        os.environ.setdefault(name, "1")


def run_pool(
    tasks: Sequence[Task], work: Work, shared: Any, workers: int
) -> Iterator[tuple[str, list[dict[str, Any]], float]]:
    """Yield (key, records, seconds) of each task as it finishes, in any order.

    With one worker everything happens in this process, in order. If the consumer stops,
    or an exception passes through, the workers are ended.
    """
    if workers <= 1 or len(tasks) <= 1:
        for task in tasks:
            yield _timed(work, shared, task)
        return
    yield from _run_processes(tasks, work, shared, min(workers, len(tasks)))


def in_own_process(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return `function(*arguments)` of a fresh process, which holds nothing of this one's.

    It ends when this process does. What the function raises is raised here.
    """
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        1, mp_context=context, initializer=_adopt, initargs=(None, None, os.getpid())
    ) as pool:
        try:
            return pool.submit(function, *arguments).result()
        except BrokenProcessPool as error:
            raise BrdfitError(
                "the process of a part of the benchmark died (killed, or out of memory). What "
                "was finished is kept: repeat the command to continue."
            ) from error


def _run_processes(
    tasks: Sequence[Task], work: Work, shared: Any, workers: int
) -> Iterator[tuple[str, list[dict[str, Any]], float]]:
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool

    context = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, context, _adopt, (work, shared, os.getpid()))
    finished = False
    try:
        with warnings.catch_warnings():
            # Forking beside a thread that draws a bar is safe: the child touches no bar.
            warnings.filterwarnings("ignore", ".*multi-threaded", DeprecationWarning)
            futures = [pool.submit(_one, task) for task in tasks]
        for future in as_completed(futures):
            yield future.result()
        finished = True
    except BrokenProcessPool as error:
        raise BrdfitError(
            "a worker process of the benchmark died (killed, or out of memory). What was "
            "finished is kept: repeat the command to continue, with fewer --workers if memory "
            "was short."
        ) from error
    finally:
        if not finished:
            for process in set(multiprocessing.active_children()) - before:
                process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


# What this worker was started with; set once per process by `_adopt`.
_ADOPTED: dict[str, Any] = {}


def _adopt(work: Work | None, shared: Any, parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    limit_threads()
    _ADOPTED.update(work=work, shared=shared)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_WATCH_SECONDS)
    os._exit(1)


def _one(task: Task) -> tuple[str, list[dict[str, Any]], float]:
    return _timed(_ADOPTED["work"], _ADOPTED["shared"], task)


def _timed(work: Work, shared: Any, task: Task) -> tuple[str, list[dict[str, Any]], float]:
    start = time.perf_counter()
    try:
        records = work(shared, task)
    except Exception as error:
        error.add_note(f"while working on {task.key}")
        raise
    return task.key, records, time.perf_counter() - start
