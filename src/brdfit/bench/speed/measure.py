"""Seconds and memory of one stage, in a process of its own."""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from brdfit.bench.ledger import Record, figure
from brdfit.bench.speed.machine import Floor, Machine

__all__ = ["Prepared", "measured", "watched_peak"]

_STATUS = Path("/proc/self/status")
_CLEAR = Path("/proc/self/clear_refs")
# What makes the kernel forget the highest memory so far (proc(5)).
_FORGET_PEAK = "5"


@dataclass(frozen=True, eq=False)
class Prepared:
    """A stage with everything at hand that is not to be timed."""

    run: Callable[[], Any]
    floor: Floor | None = None
    """None where the least is not known: what others do."""
    count: int = 0
    """Items that one run treats; 0 where there are none."""
    judge: Callable[[Any], dict[str, Any]] | None = None
    """Figures of what a run gave, beside the times."""
    told: dict[str, Any] = field(default_factory=dict)
    """Figures that are known before."""


def measured(prepared: Prepared, repeat: int, warm: bool = True) -> Record:
    """Return the figures of `repeat` runs, after one that is not counted if `warm`.

    | name | meaning |
    |---|---|
    | `times` | seconds of each run |
    | `median` | their median |
    | `processor` | median seconds of the processor, which other work on the machine spoils less |
    | `peak_mb` | highest memory of the process during the runs, all it holds counted |
    | `added_mb` | that above what it held before them |
    | `load` | load of the machine when it began, this run's own included; None where nobody tells |
    | `floor` | seconds that the stage takes at least, see `Floor` |
    | `over_floor`, `over_memory` | median over that, and over the time of its bytes alone |
    """
    load = round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None
    machine = Machine.measured()
    if warm:
        prepared.run()
    before, peak = watched_peak()
    times: list[float] = []
    busy: list[float] = []
    result = None
    for _ in range(repeat):
        result = None  # what the last run gave is not held beside the next
        start, begun = time.perf_counter(), time.process_time()
        result = prepared.run()
        times.append(time.perf_counter() - start)
        busy.append(time.process_time() - begun)
    highest = peak()
    median = statistics.median(times)
    record: Record = {
        "times": [figure(value, 4) for value in times],
        "median": figure(median, 4),
        "processor": figure(statistics.median(busy), 4),
        "peak_mb": round(highest / 1e6),
        "added_mb": round(max(highest - before, 0) / 1e6),
        "bandwidth": figure(machine.bandwidth, 4),
        "single": figure(machine.single, 4),
        "double": figure(machine.double, 4),
        "load": load,
    } | prepared.told
    if prepared.count:
        record |= {"items": prepared.count, "items_a_second": figure(prepared.count / median, 4)}
    if prepared.floor is not None:
        record |= _beside(prepared.floor, machine, median)
    if prepared.judge is not None:
        record |= prepared.judge(result)
    return record


def _beside(floor: Floor, machine: Machine, median: float) -> Record:
    return {
        "bytes": floor.moved,
        "operations": figure(floor.single + floor.double, 4),
        "counted": floor.why,
        "memory_floor": figure(floor.memory_seconds(machine), 4),
        "product_floor": figure(floor.product_seconds(machine), 4),
        "floor": figure(floor.seconds(machine), 4),
        "over_floor": figure(median / floor.seconds(machine), 4),
        "over_memory": figure(median / floor.memory_seconds(machine), 4),
    }


def watched_peak() -> tuple[int, Callable[[], int]]:
    """Return (bytes held now, function that returns the most held since).

    Where the system cannot forget an earlier peak, it is the most since the process began.
    """
    try:
        _CLEAR.write_text(_FORGET_PEAK)
        return _status("VmRSS"), lambda: _status("VmHWM")
    except OSError:
        return _highest(), _highest


def _status(name: str) -> int:
    for line in _STATUS.read_text().splitlines():
        if line.startswith(f"{name}:"):
            return int(line.split()[1]) * 1024
    raise OSError(f"{_STATUS}: no {name}")


def _highest() -> int:
    import resource  # of Unix

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
