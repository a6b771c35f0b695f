"""Read damaged files until something other than a result or an error of our own comes out.

    python tools/fuzz_readers.py --inputs 100000 --seed 1 -o benchmarks/results/fuzz.json
    python tools/fuzz_readers.py --truncations          # every small file, cut at every byte
    python tools/fuzz_readers.py --seed 1 --only 4711   # one input again, with its traceback

Each input is a small valid file (`small_files.py`) damaged by one to six mutations, and read
by its own reader or by whichever claims it. A worker process reads them under a limit of
memory; a crash, a hang or a foreign exception there is a finding, named by the seed and the
number that make the input again. Exit status 1 if there is any.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from selectors import EVENT_READ, DefaultSelector
from typing import Any

import numpy as np

from brdfit.errors import BrdfitError, BrdfitWarning
from brdfit.formats import list_formats, read_samples, read_table
from brdfit.render import Environment
from brdfit.report.environment_file import read_environment
from brdfit.samples import Samples
from brdfit.table import Table

from mutations import mutated
from small_files import ENVIRONMENT, SmallFile, small_files

MEMORY = 1 << 30
"""What reading may take beside what the process has after its imports, in bytes."""
SECONDS = 20
"""How long one input may take."""

# The threads of libraries each reserve an arena of addresses, and the limit is of addresses.
_FEW_ARENAS = {**os.environ, "MALLOC_ARENA_MAX": "2"}

# Bigger files are damaged more rarely: what costs a second is worth a hundred others.
_SMALL = 1 << 17
_RARE = 1 / 300
_ALONE = 0.05
_SHORTEST_MESSAGE = 20


# What `--plant` puts in the place of reading: proof that the fuzzer sees it.
PLANTS: dict[str, Callable[[], object]] = {
    "crash": lambda: os.kill(os.getpid(), signal.SIGSEGV),
    "foreign": lambda: {}["a defect"],
    "memory": lambda: bytearray(3 * MEMORY),
    "mute": lambda: _raise(BrdfitError("no")),
    "warning": lambda: warnings.warn("of somebody else", RuntimeWarning, stacklevel=1),
}


_READERS: dict[str, Callable[..., Samples | Table | Environment]] = {
    "samples": read_samples,
    "table": read_table,
    ENVIRONMENT: read_environment,
}


def _raise(error: Exception) -> None:
    raise error


class Hang(BaseException):
    """An input took longer than `SECONDS`."""


@dataclass(frozen=True)
class Case:
    """One damaged input."""

    number: int
    small: SmallFile
    files: dict[str, bytes]
    named: bool
    """Whether the reader is named, rather than found by the content."""


class Inputs:
    """All inputs of a run by number: the same seed makes the same."""

    def __init__(self, seed: int, formats: list[str], folder: Path) -> None:
        self._seed = seed
        known = {sheet.name for sheet in list_formats()} | {ENVIRONMENT}
        unknown = sorted(set(formats) - known)
        if unknown:
            raise SystemExit(f"no format {unknown[0]!r}; there are: {', '.join(sorted(known))}")
        self.small = [s for s in small_files(folder) if not formats or s.format in formats]
        # a large file is slow: a rare guest, unless it is all that its format has
        has_small = {s.format for s in self.small if s.size <= _SMALL}
        weights = np.array(
            [
                s.share if s.size <= _SMALL else _RARE if s.format in has_small else _ALONE
                for s in self.small
            ]
        )
        per_format = Counter(s.format for s in self.small if s.size <= _SMALL)
        weights /= np.array([max(per_format[s.format], 1) for s in self.small])
        self._weights = weights / weights.sum()

    def mutation(self, number: int) -> Case:
        """Return input `number`: a small file with a few mutations."""
        rng = np.random.default_rng([self._seed, number])
        small = self.small[int(rng.choice(len(self.small), p=self._weights))]
        files = dict(small.files)
        # what stands beside the file is damaged once in five times
        beside = [name for name in files if name != small.name]
        target = small.name if not beside or rng.random() < 0.8 else str(rng.choice(beside))
        files[target] = mutated(files[target], rng)
        return Case(number, small, files, bool(rng.random() < 0.5))

    def truncations(self) -> list[tuple[int, int]]:
        """Return (which small file, how many bytes are left) for every cut of every one."""
        cuts = []
        for which, small in enumerate(self.small):
            # of a large table: all of the header, then some
            step = 1 if small.size <= _SMALL else small.size // 40
            kept = sorted({*range(min(small.size, 64)), *range(0, small.size, step)})
            cuts += [(which, length) for length in kept]
        return cuts

    def truncation(self, number: int, cuts: list[tuple[int, int]]) -> Case:
        """Return the cut `number` of all."""
        which, length = cuts[number]
        small = self.small[which]
        files = {**small.files, small.name: small.content[:length]}
        return Case(number, small, files, named=number % 2 == 0)


def outcome_of(case: Case, folder: Path, plant: str | None = None) -> str:
    """Read one input; the name of the outcome. Anything unexpected is raised."""
    for name, content in case.files.items():
        (folder / name).write_bytes(content)
    read = _READERS[case.small.kind]
    named = case.named and case.small.kind != ENVIRONMENT
    chosen = {"format": case.small.format, **case.small.options} if named else {}
    try:
        if plant is not None:
            PLANTS[plant]()
        result = read(folder / case.small.name, **chosen)
    except BrdfitError as error:
        if len(str(error)) < _SHORTEST_MESSAGE:
            raise AssertionError(f"an error that says too little: {error!r}") from error
        return type(error).__name__
    _check(result)
    return "read"


def _check(result: Samples | Table | Environment) -> None:
    """Raise unless the result is what its class promises."""
    if isinstance(result, Environment):
        assert np.isfinite(result.radiance).all()
        assert (result.radiance >= 0.0).all()
    elif isinstance(result, Samples):
        assert np.isfinite(result.value[result.usable]).all()
        assert np.isfinite(result.wi[result.usable.any(axis=1)]).all()
        assert (result.wo[result.usable.any(axis=1), 2] > 0.0).all()
        result.flag_counts()
    else:
        assert np.isfinite(result.values[result.mask]).all()
        assert not (result.mask & ~result.grid.above_horizon).any()


def work(options: argparse.Namespace, first: int, last: int, out: Any) -> None:
    """Read the inputs `first` to `last`, a line before and a line after each."""
    # their memory is not that of an input
    import h5py  # noqa: F401
    import OpenEXR  # noqa: F401
    import pyarrow.parquet  # noqa: F401

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        inputs = Inputs(options.seed, options.formats, folder)
        cuts = inputs.truncations() if options.truncations else []
        _limit_memory()
        for number in range(first, last):
            case = inputs.truncation(number, cuts) if cuts else inputs.mutation(number)
            print(json.dumps(["start", number, case.small.format]), file=out, flush=True)
            print(json.dumps(["end", *_guarded(case, folder, options.plant)]), file=out, flush=True)


def _limit_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _guarded(case: Case, folder: Path, plant: str | None) -> tuple[str, str]:
    """Return (outcome, "") or ("finding", what)."""

    def stop(*_: object) -> None:
        raise Hang

    signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", BrdfitWarning)
            return outcome_of(case, folder, plant), ""
    except Hang:
        return "finding", f"took longer than {SECONDS} s"
    except Exception as error:  # whatever is foreign is what is looked for
        place = traceback.extract_tb(error.__traceback__)[-1]
        return "finding", f"{type(error).__name__}: {error!s:.200} ({place.name}:{place.lineno})"
    finally:
        signal.alarm(0)


def run(options: argparse.Namespace, count: int) -> tuple[Counter[tuple[str, str]], list[Any]]:
    """Have workers read inputs 0 to `count` - 1; a new one where one dies."""
    outcomes: Counter[tuple[str, str]] = Counter()
    findings: list[Any] = []
    first = 0
    while first < count:
        number, format = first, ""
        for event, *rest in _events(options, first, count):
            if event == "start":
                number, format = rest
                continue
            outcome, what = rest if event == "end" else ("finding", event)
            outcomes[format, outcome] += 1
            if outcome == "finding":
                findings.append({"input": number, "format": format, "what": what})
                print(f"input {number} ({format}): {what}", file=sys.stderr, flush=True)
            first = number + 1
    return outcomes, findings


def _events(options: argparse.Namespace, first: int, last: int) -> Iterator[list[Any]]:
    """Yield what a worker reports; ["ended ..."] where it dies or is silent for too long."""
    command = [sys.executable, __file__, "--worker", str(first), str(last)]
    command += ["--seed", str(options.seed), *(f"--format={name}" for name in options.formats)]
    command += ["--truncations"] if options.truncations else []
    command += [f"--plant={options.plant}"] if options.plant else []
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=_FEW_ARENAS) as worker,
        DefaultSelector() as selector,
    ):
        assert worker.stdout is not None
        selector.register(worker.stdout, EVENT_READ)
        silent = False
        while True:
            # the worker's own alarm cannot stop a loop in a library's C
            if not selector.select(timeout=120 + SECONDS):
                silent = True
                worker.kill()
            line = worker.stdout.readline()
            if not line:
                break
            yield json.loads(line)
        status = worker.wait()
    if silent or status:
        yield ["hung" if silent else f"ended by signal {-status}" if status < 0 else "failed"]


def report(options: argparse.Namespace, count: int, seconds: float, result: Any) -> dict[str, Any]:
    """Return what a run found, as JSON-able values."""
    outcomes, findings = result
    formats = sorted({format for format, _ in outcomes})
    return {
        "tool": "tools/fuzz_readers.py",
        "what": "truncations" if options.truncations else "mutations",
        "seed": options.seed,
        "inputs": count,
        "memory_limit_bytes": MEMORY,
        "seconds_limit": SECONDS,
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in ("brdfit", "numpy", "pyarrow")},
        },
        "outcomes": {
            name: {o: n for (f, o), n in sorted(outcomes.items()) if f == name} for name in formats
        },
        "findings": findings,
        "wall_seconds": round(seconds, 1),
    }


def _arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--inputs", type=int, default=2000, help="how many mutated inputs")
    parser.add_argument("--seed", type=int, default=1, help="makes the same inputs again")
    parser.add_argument("--format", action="append", dest="formats", default=[], help="only this")
    parser.add_argument("--truncations", action="store_true", help="cut instead of mutate")
    parser.add_argument("--only", type=int, metavar="NUMBER", help="one input, with its traceback")
    parser.add_argument("-o", "--output", type=Path, help="where the record goes (JSON)")
    parser.add_argument("--plant", choices=PLANTS, help="fail like this on purpose: is it found?")
    parser.add_argument("--worker", nargs=2, type=int, help=argparse.SUPPRESS)
    return parser.parse_args(arguments)


def main(arguments: list[str]) -> int:
    options = _arguments(arguments)
    if options.worker:
        work(options, *options.worker, sys.stdout)
        return 0
    with tempfile.TemporaryDirectory() as name:
        inputs = Inputs(options.seed, options.formats, Path(name))
        cuts = inputs.truncations()
        if options.only is not None:
            number = options.only
            case = (
                inputs.truncation(number, cuts) if options.truncations else inputs.mutation(number)
            )
            print(case.small.format, case.small.kind, "named" if case.named else "sniffed")
            print(outcome_of(case, Path(name)))
            return 0
    count = len(cuts) if options.truncations else options.inputs
    began = time.monotonic()
    record = report(options, count, time.monotonic() - began, run(options, count))
    record["wall_seconds"] = round(time.monotonic() - began, 1)
    text = json.dumps(record, indent=1) + "\n"
    if options.output is None:
        print(text, end="")
    else:
        options.output.write_text(text, encoding="utf-8")
    return 1 if record["findings"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
