"""`brdfit view`: tables, fits and measurements in the browser."""

from __future__ import annotations

import argparse
import contextlib
import webbrowser
from collections.abc import Sequence
from pathlib import Path

from brdfit.cli.commands.fit import add_method_options, method_from
from brdfit.cli.console import Console
from brdfit.cli.declaration import add_reading_options, reading_options
from brdfit.cli.parser import Parser
from brdfit.errors import MissingExtra, UsageError


def add_arguments(parser: Parser, rest: Sequence[str]) -> None:
    """Add what `brdfit view` takes; the method named in `rest` decides some of it."""
    parser.add_argument(
        "files",
        type=Path,
        nargs="*",
        metavar="FILE",
        help="Table, or any file that brdfit fit left beside it, or measurements, which are fitted "
        "first. Several stand side by side. Without one, drop a file on the page.",
    )
    parser.add_argument(
        "--port",
        type=int,
        default=0,
        metavar="NUMBER",
        help="Port on 127.0.0.1 (default: a free one).",
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="Print the address, open nothing."
    )
    add_method_options(parser, rest)
    add_reading_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> None:
    """Read the files, serve the page until Ctrl-C."""
    try:
        import msgspec  # noqa: F401
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
    except ImportError as error:
        raise MissingExtra(str(error.name), "viewer", "brdfit view") from error
    from brdfit.viewer.serve import Server
    from brdfit.viewer.workbench import Workbench

    if not 0 <= arguments.port <= 65535:
        raise UsageError(f"--port: found {arguments.port} but expected 0 to 65535.")
    options = reading_options(arguments)
    with (
        Workbench(method_from(arguments)) as bench,
        contextlib.closing(Server(bench, arguments.port)) as server,
    ):
        for path in arguments.files:
            bench.open(path, **options)
        console.say("the page, for this machine and whoever knows the token:")
        console.result(server.url)
        console.say("Ctrl-C ends it; what was uploaded is then removed.")
        if not arguments.no_browser:
            webbrowser.open(server.url)
        with contextlib.suppress(KeyboardInterrupt):
            server.run()
