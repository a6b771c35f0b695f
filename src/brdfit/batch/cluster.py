"""Dask as the engine: the workers of a cluster, or of this machine.

    with Cluster("tcp://10.0.0.1:8786") as engine:
        run_batch(source, "out.zarr", engine=engine)

Input, method and basis go to every worker once, also to one that joins later or comes back
after it died; a task is two numbers, and a result what the store keeps. The workers read the
input themselves: its path must mean the same to all of them. The store is written by the
process that asks. No more tasks are handed out than keep everybody busy.
"""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Sequence
from typing import Any

from brdfit.batch.engine import RETRIES, Range, Work
from brdfit.batch.record import PartResult
from brdfit.errors import FitError, MissingExtra, UsageError

__all__ = ["Cluster"]

_AHEAD = 3  # tasks in hand for each thread of the cluster
_PATIENCE = 60.0


class Cluster:
    """A connection to a Dask scheduler, or a cluster of single-threaded workers of this machine.

    Parameters
    ----------
    scheduler
        Address such as "tcp://10.0.0.1:8786"; left out, workers are started here.
    workers
        How many, where they are started here.

    Raises `MissingExtra` without dask, `UsageError` where the scheduler does not answer.
    """

    def __init__(self, scheduler: str | None = None, workers: int = 2) -> None:
        distributed = _distributed()
        self._own: Any = None
        if scheduler is None:
            self._own = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address=None,
                host="127.0.0.1",
            )
        try:
            self.client = distributed.Client(self._own or scheduler, timeout=10.0)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"scheduler {scheduler!r}: does not answer ({error}). Start one with: dask "
                f"scheduler, and workers with: dask worker ADDRESS --nthreads 1."
            ) from error

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_: object) -> None:
        self.client.close()
        if self._own is not None:
            self._own.close()

    def run(self, work: Work, tasks: Sequence[Range]) -> Iterator[tuple[int, PartResult]]:
        """Yield (block, result) of every task as it finishes.

        Raises `FitError` where workers keep dying over the same task.
        """
        distributed = _distributed()
        self.client.wait_for_workers(1, timeout=_PATIENCE)
        name = f"brdfit-{uuid.uuid4().hex}"
        self.client.register_plugin(_shipped(distributed)(work), name=name)
        left = list(reversed(tasks))
        held: dict[Any, Range] = {}
        try:
            finished = distributed.as_completed(with_results=False)
            while left or held:
                most = _AHEAD * max(1, sum(self.client.nthreads().values()))
                while left and len(held) < most:
                    task = left.pop()
                    future = self.client.submit(_do, name, task, pure=False, retries=RETRIES)
                    held[future.key] = task
                    finished.add(future)
                future = next(finished)
                task = held.pop(future.key)
                yield task[0], _result(distributed, future, task)
                future.release()
        finally:
            self.client.unregister_worker_plugin(name)


def _result(distributed: Any, future: Any, task: Range) -> PartResult:
    try:
        result: PartResult = future.result()
    except distributed.KilledWorker as error:
        raise FitError(
            f"workers of the cluster kept dying over items {task[1]} to {task[2] - 1} (killed, or "
            f"out of memory). What is finished is kept: repeat the command with less --memory."
        ) from error
    return result


def _do(name: str, task: Range) -> PartResult:
    work: Work = _distributed().get_worker().plugins[name].work
    return work.do(task)


def _shipped(distributed: Any) -> type:
    """Return the plugin that holds what every worker knows."""

    class Shipped(distributed.WorkerPlugin):  # type: ignore[misc]
        def __init__(self, work: Work) -> None:
            self.work = work

    return Shipped


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise MissingExtra("distributed", "cluster", "a cluster of workers") from error
    return distributed
