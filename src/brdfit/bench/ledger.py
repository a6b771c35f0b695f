"""A benchmark run that can be killed at any moment and continued with nothing lost or done twice.

A run is a list of *tasks* with stable keys; each gives *records* (JSON objects with a `key`).
While it goes on, finished tasks are appended to a journal beside the result, one JSON line
each, on the disk before the next is counted. A last line that was torn by the kill is cut off
on resume. At the end one self-contained result file is written atomically: header (settings,
versions, seeds, hashes of the inputs) and records sorted by key, nothing else, so that an
undisturbed run and one killed ten times give the same bytes. Times are kept in a file of
their own, those among the records (an entry `seconds`) as well. A journal of other settings or
other code is not continued: that is an error, and `restart` is the way out.

    out.json                the result
    out.journal.jsonl       only while a run is unfinished
    out.timings.json        seconds per task, per record that states them, and the machine
"""

from __future__ import annotations

import json
import math
import os
import platform
import tempfile
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from brdfit.bench.workers import Task, Work, run_pool
from brdfit.errors import CorruptFile, UsageError
from brdfit.files import atomic_path, sha256_of_bytes
from brdfit.progress import Progress, silent
from brdfit.versions import versions_of

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "Journal",
    "Ledger",
    "Record",
    "code_fingerprint",
    "figure",
    "read_result",
    "record_seconds",
    "versions",
]

Record = dict[str, Any]
"""One JSON object with a unique `key`."""

_LOCK_SECONDS = 10.0
# The entry of a record that no repetition gives again.
_SECONDS = "seconds"
# What draws and prints is not what a figure depends on.
_NOT_NUMERICAL = {"cli", "viewer", "report"}


def figure(value: float, digits: int = 6) -> float | None:
    """Return `value` at `digits` significant digits for a record; None if not finite."""
    number = float(value)
    return float(f"{number:.{digits}g}") if math.isfinite(number) else None


def versions() -> dict[str, str]:
    """Return the versions that a result depends on, the code's own fingerprint included."""
    return versions_of("brdfit", "numpy", "scipy") | {"code": code_fingerprint()}


def code_fingerprint() -> str:
    """Return 16 hexadecimal digits over every module of brdfit that can change a figure."""
    root = Path(__file__).resolve().parent.parent
    parts = []
    for path in sorted(root.rglob("*.py")):
        relative = path.relative_to(root)
        if relative.parts[0] not in _NOT_NUMERICAL:
            parts.append(f"{relative.as_posix()} {sha256_of_bytes(path.read_bytes())}")
    return sha256_of_bytes("\n".join(parts).encode())[:16]


@dataclass(frozen=True)
class Ledger:
    """Where a run is written, what makes it the same run, and how it is executed."""

    result: Path
    """The result file; the journal and the times lie beside it."""
    header: dict[str, Any]
    """Name, settings, versions, seeds, input hashes: equal headers, same run."""
    restart: bool = False
    """Throw an unfinished or finished run away and start afresh."""
    workers: int = field(default_factory=lambda: os.cpu_count() or 1, compare=False)
    """Processes; 1 works in this one."""

    @property
    def journal_path(self) -> Path:
        """Where finished tasks go while the run is unfinished."""
        return self.result.with_suffix(".journal.jsonl")

    @property
    def timings_path(self) -> Path:
        """Where the times go."""
        return self.result.with_suffix(".timings.json")

    @cached_property
    def plain_header(self) -> dict[str, Any]:
        """The header as JSON gives it back (tuples are lists, keys are text)."""
        return dict(json.loads(_dumps(self.header)))

    def run(
        self,
        tasks: Sequence[Task],
        work: Work,
        prepare: Callable[[Sequence[Task]], Any],
        progress: Progress = silent,
        say: Callable[[str], None] = lambda text: None,
        label: str = "benchmark",
    ) -> list[Record]:
        """Return the records of all tasks, sorted by key, and leave them in `result`.

        `work(shared, task)` is a function of a module and returns the task's records;
        `shared` is what `prepare` makes of the tasks that are left, once for all workers.
        """
        keys = [task.key for task in tasks]
        if len(set(keys)) != len(keys):
            raise UsageError("ledger: two tasks have the same key, which must name one task.")
        self.result.parent.mkdir(parents=True, exist_ok=True)
        with _only_one_run(self.journal_path):
            finished = None if self.restart else self._finished()
            if finished is not None:
                say(f"{self.result} is complete already; --restart does it again.")
                self.journal_path.unlink(missing_ok=True)
                return finished
            with Journal(self.journal_path, self.plain_header, self.restart) as journal:
                self._fill(journal, tasks, work, prepare, progress, say, label)
                records = sorted(journal.records(keys), key=lambda record: str(record["key"]))
                self._write_timings(journal, records)
                records = [_timeless(record) for record in records]
                write_result(self.result, self.plain_header, records)
            self.journal_path.unlink()
        return records

    def _fill(
        self,
        journal: Journal,
        tasks: Sequence[Task],
        work: Work,
        prepare: Callable[[Sequence[Task]], Any],
        progress: Progress,
        say: Callable[[str], None],
        label: str,
    ) -> None:
        left = [task for task in tasks if task.key not in journal.done]
        if len(left) < len(tasks):
            done = len(tasks) - len(left)
            say(f"continuing: {done} of {len(tasks)} parts were finished by an earlier run.")
        if not left:
            return
        shared = prepare(left)
        cost = {task.key: task.cost for task in tasks}
        total = sum(cost.values())
        spent = total - sum(task.cost for task in left)
        progress(label, 0, total)
        if spent:
            progress(label, spent, total)
        for key, records, seconds in run_pool(left, work, shared, self.workers):
            journal.append(key, records, seconds)
            spent += cost[key]
            progress(label, spent, total)

    def _finished(self) -> list[Record] | None:
        if not self.result.exists():
            return None
        try:
            found = read_result(self.result)
        except CorruptFile:
            return None
        records = found.pop("records")
        return list(records) if found == self.plain_header else None

    def _write_timings(self, journal: Journal, records: Sequence[Record]) -> None:
        machine = {"cpus": os.cpu_count(), "platform": platform.platform(), "workers": self.workers}
        total = sum(journal.seconds.values())
        times = {key: round(journal.seconds[key], 3) for key in sorted(journal.seconds)}
        fits = {str(one["key"]): one[_SECONDS] for one in records if _SECONDS in one}
        content = {
            "machine": machine,
            "seconds_of_work": round(total, 1),
            "seconds": times,
            "records": fits,
        }
        with atomic_path(self.timings_path) as aside:
            aside.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


class Journal:
    """The finished tasks of an unfinished run, one line each, on the disk when counted."""

    def __init__(self, path: Path, header: dict[str, Any], restart: bool = False) -> None:
        self.path = path
        self.header = header
        self.done: dict[str, list[Record]] = {}
        self.seconds: dict[str, float] = {}
        if restart:
            path.unlink(missing_ok=True)
        self._keep = self._load() if path.exists() else 0

    def __enter__(self) -> Journal:
        self._stream: IO[bytes] = open(self.path, "ab")
        self._stream.truncate(self._keep)
        if self._keep == 0:
            self._write({"header": self.header})
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()

    def append(self, key: str, records: list[Record], seconds: float) -> None:
        """Put the records of a finished task on the disk."""
        entry = {"task": key, "seconds": round(seconds, 4), "records": records}
        self._write(entry)
        self._accept(json.loads(_dumps(entry)))

    def records(self, keys: Sequence[str]) -> list[Record]:
        """Return the records of these tasks."""
        return [record for key in keys for record in self.done[key]]

    def _write(self, entry: dict[str, Any]) -> None:
        self._stream.write((_dumps(entry) + "\n").encode())
        self._stream.flush()
        os.fsync(self._stream.fileno())

    def _accept(self, entry: dict[str, Any]) -> None:
        self.done[entry["task"]] = entry["records"]
        self.seconds[entry["task"]] = entry["seconds"]

    def _load(self) -> int:
        """Read the whole lines; return how many bytes of the file they are."""
        lines = self.path.read_bytes().split(b"\n")
        # What follows the last line feed was torn by the kill, or is empty.
        whole, kept = lines[:-1], 0
        for number, line in enumerate(whole):
            try:
                entry = json.loads(line)
            except ValueError:
                if number == len(whole) - 1:
                    break
                raise CorruptFile(
                    f"{self.path}: line {number + 1} of {len(whole)} is not JSON but each line "
                    f"is one finished part. Start afresh with --restart."
                ) from None
            if number == 0:
                self._check_header(entry)
            else:
                self._accept(entry)
            kept += len(line) + 1
        return kept

    def _check_header(self, entry: dict[str, Any]) -> None:
        found = entry.get("header", {})
        if found != self.header:
            other = _differences(found, self.header)
            raise UsageError(
                f"{self.path}: an unfinished run was made with other {other}. Repeat the "
                f"command it was started with to finish it, or start afresh with --restart, which "
                f"throws its finished parts away."
            )


def record_seconds(result: Path) -> dict[str, float]:
    """Return the seconds of the records that stated them, by key, from beside a result."""
    path = result.with_suffix(".timings.json")
    try:
        found = json.loads(path.read_text(encoding="utf-8")).get("records", {})
    except (OSError, ValueError):
        return {}
    return {str(key): float(value) for key, value in found.items()}


def _timeless(record: Record) -> Record:
    return {name: value for name, value in record.items() if name != _SECONDS}


def read_result(path: Path) -> dict[str, Any]:
    """Return the content of a result file: the header's entries and `records`."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise CorruptFile(f"{path}: found no JSON but a benchmark result is ({error}).") from error
    if not isinstance(content, dict) or not isinstance(content.get("records"), list):
        raise CorruptFile(f"{path}: found no list of records; this is no benchmark result.")
    return content


def write_result(path: Path, header: dict[str, Any], records: Sequence[Record]) -> None:
    """Write header and records, one record a line, whole or not at all."""
    head = json.dumps(header, indent=1, sort_keys=True, allow_nan=False).rstrip("}").rstrip()
    body = ",\n".join("  " + _dumps(record) for record in records)
    with atomic_path(path) as aside:
        aside.write_text(f'{head},\n "records": [\n{body}\n ]\n}}\n', encoding="utf-8")


@contextmanager
def _only_one_run(journal: Path) -> Iterator[None]:
    from filelock import FileLock, Timeout

    # Elsewhere, under a name of its own, so that no lock file is left among the results.
    name = sha256_of_bytes(str(journal.resolve()).encode())[:16]
    lock = FileLock(Path(tempfile.gettempdir()) / f"brdfit-bench-{name}.lock")
    try:
        # The workers of a killed run hold the lock until they notice, within a second.
        lock.acquire(timeout=_LOCK_SECONDS)
    except Timeout:
        raise UsageError(
            f"{journal}: another run is writing here. Wait for it, or choose another output."
        ) from None
    try:
        yield
    finally:
        lock.release()


def _differences(found: dict[str, Any], wanted: dict[str, Any], prefix: str = "") -> str:
    named = []
    for key in sorted({*found, *wanted}):
        one, other = found.get(key), wanted.get(key)
        if isinstance(one, dict) and isinstance(other, dict):
            inner = _differences(one, other, f"{prefix}{key}.")
            named += [inner] if inner else []
        elif one != other:
            named.append(f"{prefix}{key} ({_short(one)}, now {_short(other)})")
    return ", ".join(named)


def _short(value: object) -> str:
    text = _dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _dumps(value: object) -> str:
    return json.dumps(value, sort_keys=True, allow_nan=False)
