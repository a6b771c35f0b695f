"""`brdfit batch`: very many items in, a store of compact results out."""

from __future__ import annotations

import argparse
import os
import re
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from brdfit.bench.workers import limit_threads
from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.cli.settings import add_settings, given_settings
from brdfit.errors import UsageError

if TYPE_CHECKING:
    from brdfit.batch.engine import Engine
    from brdfit.batch.run import RunSummary
    from brdfit.batch.source import BatchInput
    from brdfit.reconstruct import Compact

_UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit batch` takes."""
    # Before numpy is imported: the processes are the parallelism.
    limit_threads()
    from brdfit.reconstruct.compact import Compact

    parser.add_argument(
        "input",
        metavar="INPUT",
        help="Folder of measurement files, a pattern in quotes ('scans/*.csv'), or one long table "
        "(.parquet, or a Zarr group of columns): item, directions, values.",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="OUT.zarr",
        help="Store to write, or to continue. One item of it is OUT.zarr#NAME to other commands.",
    )
    parser.add_argument(
        "--item", metavar="COLUMN", help="Column of a long table that names the item of a row."
    )
    parser.add_argument(
        "--position",
        metavar="X,Y",
        help="Columns of the pixel position of an item (default: x,y if there are such).",
    )
    parser.add_argument(
        "--basis",
        default="embedded",
        metavar="NAME|PATH",
        help="Population to lean on (default: embedded).",
    )
    parser.add_argument(
        "--textures",
        type=Path,
        metavar="DIR",
        help="Write maps for renderers too: base colour, specular, roughness, how far to trust "
        "them, all coefficients, a MaterialX material and a relit preview.",
    )
    _add_running(parser)
    add_settings(parser.add_argument_group("settings of compact"), Compact, ("population",))
    add_reading_options(parser)


def _add_running(parser: Parser) -> None:
    group = parser.add_argument_group("running")
    group.add_argument(
        "--workers",
        type=_workers,
        default=None,
        metavar="N",
        help="Processes that fit (default: one for each core).",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="Address of a Dask scheduler whose workers fit in place of processes of this machine, "
        "such as tcp://10.0.0.1:8786; local starts workers here.",
    )
    group.add_argument(
        "--memory",
        type=_bytes,
        default=_bytes("1GB"),
        metavar="SIZE",
        help="What all processes may take together, such as 800MB or 2GB (default: 1GB).",
    )
    group.add_argument(
        "--restart", action="store_true", help="Begin anew where OUT.zarr holds another batch."
    )


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Open the input, fit what is not done yet, say what came of it."""
    from brdfit.batch import open_input, run_batch

    position = tuple(filter(None, (arguments.position or "").split(",")))
    source = open_input(arguments.input, reading_options(arguments), arguments.item, position)
    _say_input(source, console)
    if arguments.textures is not None and not source.positioned:
        raise UsageError(
            f"--textures: the items of {source.name} have no pixel position. Give a long table "
            f"with columns x and y, or name them: --position X,Y."
        )
    workers = arguments.workers or len(os.sched_getaffinity(0))
    started = time.perf_counter()
    with console.progress(unit="items") as progress, _engine(arguments, workers) as engine:
        summary = run_batch(
            source,
            arguments.output,
            _method(arguments),
            engine=engine,
            workers=workers,
            memory=arguments.memory,
            restart=arguments.restart,
            progress=progress,
        )
    _say_summary(summary, time.perf_counter() - started, console)
    if arguments.textures is not None:
        _write_textures(arguments, console)


def _write_textures(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.batch import open_batch
    from brdfit.export.textures import write_textures

    with console.progress() as progress:
        write_textures(open_batch(arguments.output), arguments.textures, progress)
    console.say(f"wrote {arguments.textures} (maps, material.mtlx, preview.png)")


def _method(arguments: argparse.Namespace) -> Compact:
    from brdfit.reconstruct import Compact

    return Compact(population=arguments.basis, **given_settings(arguments))


@contextmanager
def _engine(arguments: argparse.Namespace, workers: int) -> Iterator[Engine]:
    from brdfit.batch.engine import Here, Processes

    if arguments.scheduler is None:
        yield Here() if workers == 1 else Processes(workers)
        return
    from brdfit.batch.cluster import Cluster

    address = None if arguments.scheduler == "local" else arguments.scheduler
    with Cluster(address, workers) as cluster:
        yield cluster


def _say_input(source: BatchInput, console: Console) -> None:
    where = ", with pixel positions" if source.positioned else ""
    names = source.channels
    shown = ", ".join(names) if len(names) < 7 else f"{len(names)} channels"
    console.say(
        f"{source.name}: {source.count:,} items of about {source.samples_per_item:.0f} samples, "
        f"{shown}{where}"
    )
    for note in getattr(source, "notes", ()):
        console.say(f"  note        {note}")


def _say_summary(summary: RunSummary, seconds: float, console: Console) -> None:
    if summary.continued and not summary.fitted:
        console.say(f"{summary.store}: is complete; there was nothing left to do")
    elif summary.continued:
        console.say(f"continued; {summary.items - summary.fitted:,} items were done before")
    if summary.fitted:
        rate = summary.fitted / max(seconds, 1e-9)
        console.say(f"fitted {summary.fitted:,} items in {seconds:.1f} s ({rate:,.0f} a second)")
    for name, why in summary.failed:
        said = why if why.startswith(name) else f"{name}: {why}"
        console.warn("DataQualityWarning", said)
    more = summary.failures - len(summary.failed)
    if more:
        console.warn("DataQualityWarning", f"{more:,} more items could not be fitted")
    for code, count in summary.outcomes.items():
        console.say(f"  {count:9,}   {code}")
    if summary.fitted:
        console.say(f"wrote {summary.store}")
    if summary.example:
        console.say(f"one item: brdfit convert '{summary.store}#{summary.example}' OUT.binary")


def _workers(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"found {text!r} but expected a whole number >= 1")
    return int(text)


def _bytes(text: str) -> int:
    """Return the bytes of 800MB, 2GB, 1.5g."""
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([kmgt]?)i?b?\s*", text.lower())
    if match is None:
        raise argparse.ArgumentTypeError(f"found {text!r} but expected a size such as 800MB or 2GB")
    return int(float(match[1]) * _UNITS[match[2]])
