"""What a command may say: results to standard output, the rest to standard error."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from brdfit.cli.bar import Bar
from brdfit.errors import BrdfitWarning
from brdfit.progress import Progress, silent

__all__ = ["Console"]


class Console:
    """Standard output and error of one run of the program.

    A reader that goes away (`brdfit info x | head -1`) ends the talking, never the work.
    """

    def __init__(
        self,
        out: TextIO | None = None,
        err: TextIO | None = None,
        *,
        quiet: bool = False,
        debug: bool = False,
    ) -> None:
        self.out = sys.stdout if out is None else out
        self.err = sys.stderr if err is None else err
        self.quiet = quiet
        self.debug = debug
        self.warnings: list[str] = []
        """What was warned of, "Name: message", each once and in order."""
        self._bar: Bar | None = None

    def say(self, text: str = "") -> None:
        """Print a line of the report; nothing with --quiet."""
        if not self.quiet:
            self.result(text)

    def result(self, text: str) -> None:
        """Print what the command was called for, with --quiet also."""
        self._write(self.out, text)

    def remark(self, text: str) -> None:
        """Print a line beside the result, on standard error; nothing with --quiet."""
        if not self.quiet:
            self._error_line(text)

    def warn(self, name: str, text: str) -> None:
        """Print and keep a named warning."""
        line = f"{name}: {text}"
        if line in self.warnings:
            return
        self.warnings.append(line)
        self._error_line(f"brdfit: warning: {line}")

    def fail(self, text: str) -> None:
        """Print an error."""
        self._error_line(f"brdfit: error: {text}")

    @contextmanager
    def progress(self, unit: str = "") -> Iterator[Progress]:
        """Give a `Progress` that draws a bar if the work lasts over a second and may talk.

        With a `unit` the work called so tells how many a second there are, too.
        """
        if self.quiet:
            yield silent
            return
        bar = Bar(self.err, unit=unit)
        self._bar = bar
        try:
            yield bar
        finally:
            self._bar = None
            bar.close()

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Print and keep brdfit's warnings while the block runs; others as Python does."""
        with warnings.catch_warnings():
            warnings.simplefilter("always", BrdfitWarning)
            usual = warnings.showwarning

            def show(
                message: Warning | str,
                category: type[Warning],
                filename: str,
                lineno: int,
                file: TextIO | None = None,
                line: str | None = None,
            ) -> None:
                if issubclass(category, BrdfitWarning):
                    self.warn(category.__name__, str(message))
                else:
                    usual(message, category, filename, lineno, file, line)

            warnings.showwarning = show
            yield

    def _error_line(self, text: str) -> None:
        if self._bar is not None:
            self._bar.clear()
        self._write(self.err, text)

    def _write(self, stream: TextIO, text: str) -> None:
        encoding = getattr(stream, "encoding", None) or "utf-8"
        # A terminal that cannot show a letter gets a question mark, not a crash.
        line = (text + "\n").encode(encoding, "replace").decode(encoding)
        try:
            stream.write(line)
            stream.flush()
        except BrokenPipeError:
            self._unplug(stream)

    def _unplug(self, stream: TextIO) -> None:
        # Python flushes both streams at exit, which would fail once more.
        import os

        silent = open(os.devnull, "w")  # noqa: SIM115 - lives as long as the program
        with_descriptor = stream in (sys.__stdout__, sys.__stderr__)
        if with_descriptor:
            os.dup2(silent.fileno(), stream.fileno())
        if stream is self.out:
            self.out = silent
        else:
            self.err = silent
