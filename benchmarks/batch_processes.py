"""Runs of `brdfit batch` in processes of their own: how much memory they take, and their end."""

from __future__ import annotations

import signal
import subprocess
import threading
import time
from pathlib import Path

from brdfit.batch import open_batch


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
