"""A progress bar that shows itself only when the work lasts."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.progress import Progress as RichProgress
    from rich.progress import TaskID

__all__ = ["Bar"]

_DELAY = 1.0
_LINE_EVERY = 5.0


class Bar:
    """A `brdfit.progress.Progress`: a bar on a terminal, now and then a line elsewhere.

    Nothing is shown in the first `delay` seconds after the first call. A timer shows it
    then, because the work may not call again for long.
    """

    def __init__(
        self,
        stream: TextIO,
        delay: float = _DELAY,
        clock: Callable[[], float] = time.monotonic,
        unit: str = "",
    ) -> None:
        self._unit = unit
        self._rate = Rate(clock)
        self._stream = stream
        self._delay = delay
        self._clock = clock
        self._lock = threading.RLock()
        self._timer: threading.Timer | None = None
        self._begun: float | None = None
        self._last_line = float("-inf")
        self._now: tuple[str, int, int] = ("", 0, 0)
        self._rich: RichProgress | None = None
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, label: str, done: int, total: int) -> None:
        """Take note of `done` of `total` steps of the work called `label`."""
        with self._lock:
            self._now = (label, done, total)
            if label == self._unit:
                self._rate.note(done)
            if self._begun is None:
                self._begun = self._clock()
                self._timer = threading.Timer(self._delay, self._draw)
                self._timer.daemon = True
                self._timer.start()
            elif self._clock() - self._begun >= self._delay:
                self._draw()

    def clear(self) -> None:
        """Take the bar off the terminal, so that a line can be printed; it comes back."""
        with self._lock:
            if self._rich is not None:
                self._rich.stop()
                self._rich = None
                self._tasks = {}

    def close(self) -> None:
        """End: stop the timer and take the bar off the terminal."""
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
            # A timer that has already fired finds nothing to show.
            self._now = ("", 0, 0)
            self.clear()

    def _draw(self) -> None:
        with self._lock:
            label, done, total = self._now
            if not label:
                return
            if self._stream.isatty():
                self._draw_bar(label, done, total)
            else:
                self._draw_line(label, done, total)

    def _draw_line(self, label: str, done: int, total: int) -> None:
        now = self._clock()
        if now - self._last_line < _LINE_EVERY or self._begun is None:
            return
        self._last_line = now
        share = f"{100 * done // total} %" if total else f"{done}"
        rate = f", {self._rate.words(total)}" if label == self._unit else ""
        try:
            self._stream.write(f"brdfit: {label}: {share} ({now - self._begun:.0f} s{rate})\n")
            self._stream.flush()
        except (BrokenPipeError, ValueError):
            # Nobody listens any more: the work matters, the talk does not.
            self._now = ("", 0, 0)

    def _draw_bar(self, label: str, done: int, total: int) -> None:
        if self._rich is None:
            self._rich = _rich_progress(self._stream)
            self._rich.start()
        if label not in self._tasks:
            for task in self._tasks.values():
                self._rich.update(task, visible=False)
            self._tasks[label] = self._rich.add_task(label, total=None)
        shown = f"{label}, {self._rate.words(total)}" if label == self._unit else label
        self._rich.update(
            self._tasks[label],
            completed=done,
            total=total or None,
            visible=True,
            description=shown,
        )


class Rate:
    """How many there are a second, of those that were done while it was watched."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._first: tuple[float, int] | None = None
        self._last = (0.0, 0)

    def note(self, done: int) -> None:
        """Take note of how many are done now."""
        self._last = (self._clock(), done)
        self._first = self._first or self._last

    def words(self, total: int) -> str:
        """Return the rate and the time that the rest of `total` will take."""
        if self._first is None or self._last[1] <= self._first[1]:
            return "0 a second"
        seconds = max(self._last[0] - self._first[0], 1e-9)
        rate = (self._last[1] - self._first[1]) / seconds
        return f"{rate:,.0f} a second, {max(total - self._last[1], 0) / rate:.0f} s left"


def _rich_progress(stream: TextIO) -> RichProgress:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=Console(file=stream),
        transient=True,
        redirect_stdout=False,
        redirect_stderr=False,
    )
