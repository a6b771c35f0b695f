"""`brdfit basis`: what a fit may lean on."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Sequence

from brdfit.cli.console import Console
from brdfit.cli.parser import Command, Parser, add_commands
from brdfit.errors import PopulationError


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add list, build, check, fetch and clear."""
    commands = [
        Command("list", "List the populations that have a name, and which are ready.", _add_list),
        Command("build", "Build what a fit needs of a population, once.", _add_build),
        Command("check", "Compare a population's files with what they must be.", _add_check),
        Command("fetch", "Download a population, checked by hash.", _add_fetch),
        Command("clear", "Remove what was built; downloads stay.", _add_clear),
    ]
    add_commands(parser, commands, rest, "action")


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Run the action that was named."""
    arguments.action(arguments, console)


def _add_list(parser: Parser, rest: Sequence[str]) -> None:
    parser.add_argument("--json", action="store_true", help="Print JSON, for scripts.")
    parser.set_defaults(action=_list)


def _add_build(parser: Parser, rest: Sequence[str]) -> None:
    _add_population(parser)
    parser.set_defaults(action=_build)


def _add_check(parser: Parser, rest: Sequence[str]) -> None:
    _add_population(parser)
    parser.add_argument("--json", action="store_true", help="Print JSON, for scripts.")
    parser.set_defaults(action=_check)


def _add_fetch(parser: Parser, rest: Sequence[str]) -> None:
    parser.add_argument("population", metavar="NAME", help="A population of `brdfit basis list`.")
    parser.add_argument("--url", help="Another place of the same file, such as a mirror.")
    parser.set_defaults(action=_fetch)


def _add_clear(parser: Parser, rest: Sequence[str]) -> None:
    parser.add_argument(
        "--stale-only", action="store_true", help="Remove only what nothing will read again."
    )
    parser.set_defaults(action=_clear)


def _add_population(parser: Parser) -> None:
    parser.add_argument(
        "population",
        nargs="?",
        default="published",
        metavar="NAME|PATH",
        help="A name of `brdfit basis list`, a folder of MERL .binary files, or a zip of decoded "
        "networks (default: published).",
    )


def _list(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.populations import list_populations

    populations = list_populations()
    if arguments.json:
        console.result(json.dumps([dataclasses.asdict(one) for one in populations], indent=1))
        return
    for one in populations:
        state = "ready" if one.available else "not here"
        built = ", built" if one.built else ""
        console.result(f"{one.name:<10} {state}{built}: {one.title}")
        console.result(f"           terms: {one.terms}")
        if one.advice:
            console.result(f"           to use it: {one.advice}")


def _build(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.populations import build, cache_folder

    with console.progress() as progress:
        columns = build(arguments.population, progress=progress)
    console.say(
        f"built {arguments.population}: {len(columns.population)} members, in "
        f"{cache_folder('columns')}"
    )


def _check(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.populations import check

    with console.progress() as progress:
        report = check(arguments.population, progress=progress)
    if arguments.json:
        console.result(json.dumps(dataclasses.asdict(report) | {"ok": report.ok}, indent=1))
    else:
        for finding in report.findings:
            console.result(f"{finding.subject}: {finding.verdict}. {finding.explanation}")
    if not report.ok:
        wrong = [finding.subject for finding in report.findings if not finding.ok]
        raise PopulationError(
            f"population {report.name!r}: {len(wrong)} of {len(report.findings)} findings are not "
            f"as they must be, first {wrong[0]}."
        )


def _fetch(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.populations import fetch, list_populations

    for one in list_populations():
        if one.name == arguments.population:
            console.say(f"{one.title}\nterms: {one.terms}\npage: {one.page}")
    with console.progress() as progress:
        path = fetch(arguments.population, url=arguments.url, progress=progress)
    console.say(f"fetched {path}. Use it with: --basis {arguments.population}")


def _clear(arguments: argparse.Namespace, console: Console) -> None:
    from brdfit.populations import clear

    cleared = clear(stale_only=arguments.stale_only)
    console.say(f"removed {cleared.entries} entries, {cleared.bytes / 1e6:.1f} MB")
