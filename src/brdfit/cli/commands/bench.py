"""`brdfit bench`: run a benchmark by name."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module

from brdfit.bench.workers import limit_threads
from brdfit.cli.console import Console
from brdfit.cli.parser import Command, Parser, add_commands

BENCHMARKS = {
    "holdout": "Fit a part of real measurements, predict the rest.",
    "paper": "Every table of the published method, on a population of choice.",
    "sparse": "Held-out materials from 8 to 4000 samples, every method side by side.",
    "speed": "Seconds, memory and ratio to the least possible of every stage, beside others.",
    "sweep": "Values of open constants compared, on materials set apart for that.",
}
"""Benchmark -> one sentence. Its module is `brdfit.bench.<name>`."""


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add the benchmarks; the one that `rest` names is imported."""
    commands = [Command(name, text, _filler(name)) for name, text in BENCHMARKS.items()]
    add_commands(parser, commands, rest, "benchmark")


def _filler(name: str):  # type: ignore[no-untyped-def]
    def fill(parser: Parser, rest: Sequence[str]) -> None:
        # Before numpy is imported: the workers are the parallelism, one thread each.
        limit_threads()
        module = import_module(f"brdfit.bench.{name}")
        module.add_arguments(parser)
        parser.set_defaults(benchmark=module.run)

    return fill


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Run the benchmark with a progress bar."""
    with console.progress() as progress:
        arguments.benchmark(arguments, progress, console.say)
