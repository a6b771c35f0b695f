"""`main`: run one command; errors become one clear message and an exit code.

| code | meaning                                                        |
|------|----------------------------------------------------------------|
| 0    | done                                                           |
| 1    | failed: the file, the fit or the machine                       |
| 2    | wrong usage: an argument or option that cannot mean anything   |
| 130  | stopped with Ctrl-C (143: by a termination signal; 129: its    |
|      | terminal was closed)                                           |
"""

from __future__ import annotations

import argparse
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from types import FrameType
from typing import Any

from brdfit.cli.console import Console
from brdfit.cli.parser import Command, Parser, add_commands
from brdfit.errors import BrdfitError, UsageError

__all__ = ["COMMANDS", "build_parser", "main"]

_DESCRIPTION = (
    "Turn few, irregular, partly wrong reflectance measurements into a complete BRDF, and say "
    "how far to trust each part of it."
)
_EPILOG = """exit codes: 0 done, 1 failed, 2 wrong usage, 130 stopped with Ctrl-C"""

COMMANDS = {
    "fit": "Fit measurements: write the complete BRDF, a picture, a record and the samples.",
    "batch": "Fit very many items: archives, textures; a run that was stopped goes on.",
    "info": "Say what is in a file of measurements or a table.",
    "convert": "Read a file in one format, write it in another.",
    "export": "Fit the material parameters of a renderer to a table (MaterialX, glTF).",
    "repair": "Put right what physics forbids in a file, and list every change.",
    "evaluate": "Evaluate a table at directions of your own.",
    "compare": "Say how far one BRDF is from another.",
    "report": "Write one HTML file that shows and explains a fit, to look at or to archive.",
    "render": "Render a table as a sphere, without an external renderer.",
    "view": "Look at tables, fits and measurements in the browser.",
    "basis": "List, build, check or fetch what a fit may lean on.",
    "bench": "Run a benchmark and write its results.",
    "demo": "Make demonstration measurements and run the main job on them.",
}
"""Command -> one sentence. Its module is `brdfit.cli.commands.<name>`."""

Run = Callable[[argparse.Namespace, Console], None]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program with the words `argv` (default: those typed); return the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    # Known before the words are parsed, which may fail too.
    console = Console(quiet="-q" in words or "--quiet" in words, debug="--debug" in words)
    with console.listening(), _termination():
        return _run(words, console)


def build_parser(words: Sequence[str]) -> Parser:
    """Return the parser; only the command that `words` names is imported and filled in."""
    parser = Parser(prog="brdfit", description=_DESCRIPTION, epilog=_EPILOG)
    parser.add_argument("--version", action=_Version, nargs=0, help="Print the version and exit.")
    _add_common(parser)
    commands = [Command(name, text, _filler(name)) for name, text in COMMANDS.items()]
    add_commands(parser, commands, words, "command")
    return parser


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import PackageNotFoundError, version

        try:
            print(f"brdfit {version('brdfit')}")
        except PackageNotFoundError:
            print("brdfit, from a source tree that is not installed")
        parser.exit()


def _filler(name: str) -> Callable[[Parser, Sequence[str]], None]:
    def fill(parser: Parser, rest: Sequence[str]) -> None:
        module = import_module(f"brdfit.cli.commands.{name}")
        module.add_arguments(parser, rest)
        _add_common(parser)
        parser.set_defaults(run=module.run)

    return fill


def _add_common(parser: Parser) -> None:
    inherited: dict[str, Any] = {} if parser.prog == "brdfit" else {"default": argparse.SUPPRESS}
    group = parser.add_argument_group("everywhere")
    group.add_argument(
        "-q", "--quiet", action="store_true", help="Print warnings and errors only.", **inherited
    )
    group.add_argument(
        "--debug", action="store_true", help="Show where an error arose.", **inherited
    )


def _parse(words: Sequence[str]) -> argparse.Namespace:
    arguments, rest = build_parser(words).parse_known_args(words)
    if rest:
        _refuse(arguments, rest)
    return arguments


def _refuse(arguments: argparse.Namespace, rest: Sequence[str]) -> None:
    speaker: Parser = arguments.speaker
    sentences = speaker.unknown_options(rest)
    speaker.typed = ()
    speaker.error(" ".join(sentences) or f"nothing is known of: {' '.join(rest)}")


def _run(words: Sequence[str], console: Console) -> int:
    try:
        arguments = _parse(words)
        arguments.run(arguments, console)
    except SystemExit as end:
        return int(end.code or 0)
    except KeyboardInterrupt:
        console.fail("stopped; nothing half-written was left behind.")
        return 130
    except _Terminated as ended:
        return ended.code
    except BrdfitError as error:
        return _failed(console, str(error), 2 if isinstance(error, UsageError) else 1)
    except OSError as error:
        return _failed(console, _about_os_error(error), 1)
    except MemoryError:
        return _failed(console, "out of memory. Fit fewer samples or channels at once.", 1)
    except Exception as error:
        text = (
            f"{type(error).__name__}: {error}. This is a defect of brdfit, not of your data: "
            f"please report it with what --debug shows."
        )
        return _failed(console, text, 1)
    return 0


def _failed(console: Console, text: str, code: int) -> int:
    if console.debug:
        traceback.print_exc(file=console.err)
    console.fail(text)
    return code


def _about_os_error(error: OSError) -> str:
    reason = error.strerror or str(error)
    if error.filename is None:
        return reason
    advice = " Check the path." if isinstance(error, FileNotFoundError) else ""
    return f"{error.filename}: {reason}.{advice}"


class _Terminated(BaseException):
    """The process was asked to end: unwind, so that no half-written file stays."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.code = 128 + number


@contextmanager
def _termination() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise _Terminated(number)

    # the terminal that is closed counts, unless somebody saw to it that it does not (nohup)
    asked = [getattr(signal, name, None) for name in ("SIGTERM", "SIGHUP")]
    before = {
        one: signal.signal(one, stop)
        for one in asked
        if one is not None and signal.getsignal(one) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
