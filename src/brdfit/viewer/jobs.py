"""Fits one after another on a thread of their own, watched and cancelled from elsewhere."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from brdfit.errors import BrdfitError, UsageError
from brdfit.progress import Progress
from brdfit.viewer.item import Item
from brdfit.viewer.messages import Job
from brdfit.viewer.store import NotThere

__all__ = ["Jobs", "Work"]

Work = Callable[[Progress], Item]
"""What a job does; its result is the item that `Job.entry` names."""

_MOST_WAITING = 20
_MOST_KEPT = 200
_ENDED = ("done", "failed", "cancelled")


class _Cancelled(Exception):
    """Raised inside the work, at its next report of progress."""


class _Running:
    def __init__(self, job: Job, keep: bool) -> None:
        self.job = job
        self.keep = keep
        self.cancelled = False
        self.begun: float | None = None
        self.watchers = 0
        self.deserted: float | None = time.monotonic()


class Jobs:
    """A queue of fits. A fit runs alone: two at once would each take twice as long.

    A job that nobody watches for `patience` seconds, because its page was closed, is
    cancelled, unless it was to be kept in any case.
    """

    def __init__(self, patience: float = 10.0) -> None:
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix="brdfit-fit")
        self._all: OrderedDict[str, _Running] = OrderedDict()
        self._changed = threading.Condition()
        self._patience = patience

    def start(
        self,
        id: str,
        title: str,
        work: Work,
        *,
        replaces: str | None = None,
        keep: bool = False,
    ) -> Job:
        """Queue `work`; `UsageError` where too much waits already."""
        job = Job(id, title, "waiting", "waiting", 0, 0, 0.0, None, replaces, "")
        with self._changed:
            waiting = sum(one.job.state == "waiting" for one in self._all.values())
            if waiting >= _MOST_WAITING:
                raise UsageError(
                    f"{waiting} fits are waiting already; cancel some or wait until they are done."
                )
            running = self._all[id] = _Running(job, keep)
            while len(self._all) > _MOST_KEPT and self._oldest().job.state in _ENDED:
                self._all.popitem(last=False)
        self._pool.submit(self._run, running, work)
        return job

    def get(self, id: str) -> Job:
        """Return a job as it is now; `NotThere` if there is none of this id."""
        with self._changed:
            return self._named(id).job

    def cancel(self, id: str) -> Job:
        """Ask a job to stop; it does so at its next report of progress."""
        with self._changed:
            running = self._named(id)
            running.cancelled = True
            if running.job.state == "waiting":
                self._set(running, state="cancelled", label="cancelled")
            return running.job

    def watch(self, id: str) -> None:
        """Note that somebody watches."""
        with self._changed:
            running = self._named(id)
            running.watchers += 1
            running.deserted = None

    def unwatch(self, id: str) -> None:
        """Note that somebody no longer watches."""
        with self._changed:
            running = self._all.get(id)
            if running is not None:
                running.watchers -= 1
                if running.watchers <= 0:
                    running.deserted = time.monotonic()

    def close(self) -> None:
        """Cancel everything and wait until nothing runs."""
        with self._changed:
            for running in self._all.values():
                running.cancelled = True
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _oldest(self) -> _Running:
        return next(iter(self._all.values()))

    def _named(self, id: str) -> _Running:
        if id not in self._all:
            raise NotThere(f"{id}: there is no such fit.")
        return self._all[id]

    def _set(self, running: _Running, **changes: object) -> None:
        seconds = 0.0 if running.begun is None else time.monotonic() - running.begun
        running.job = replace(running.job, seconds=round(seconds, 2), **changes)  # type: ignore[arg-type]

    def _run(self, running: _Running, work: Work) -> None:
        with self._changed:
            if running.job.state != "waiting" or self._stops(running):
                self._set(running, state="cancelled", label="cancelled")
                return
            running.begun = time.monotonic()
            self._set(running, state="running", label="starting")
        try:
            item = work(lambda label, done, total: self._report(running, label, done, total))
        except _Cancelled:
            self._end(running, state="cancelled", label="cancelled")
        except BrdfitError as error:
            self._end(running, state="failed", label="failed", message=str(error))
        except MemoryError:
            self._end(running, state="failed", label="failed", message="out of memory")
        except Exception as error:
            text = f"{type(error).__name__}: {error}. This is a defect of brdfit: please report it."
            self._end(running, state="failed", label="failed", message=text)
        else:
            self._end(running, state="done", label="done", entry=item.id)

    def _end(self, running: _Running, **changes: object) -> None:
        with self._changed:
            self._set(running, **changes)

    def _report(self, running: _Running, label: str, done: int, total: int) -> None:
        with self._changed:
            if self._stops(running):
                raise _Cancelled
            self._set(running, label=label, done=done, total=total)

    def _stops(self, running: _Running) -> bool:
        left = running.deserted
        deserted = left is not None and time.monotonic() - left > self._patience
        return running.cancelled or (deserted and not running.keep)
