"""What may be typed: commands that are filled in only when named, and "did you mean"."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

__all__ = ["Command", "Parser", "add_commands", "did_you_mean", "first_positional"]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return " Did you mean ...?" for the nearest of `known`, or nothing."""
    by_lower = {name.lower(): name for name in known}
    near = difflib.get_close_matches(word.lower(), by_lower, n=1, cutoff=0.6)
    return f" Did you mean {by_lower[near[0]]}?" if near else ""


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors name what was mistyped and where help is.

    Usage errors end the program with exit code 2.
    """

    typed: Sequence[str] = ()
    """The words that this parser is about to read."""

    def __init__(self, *args: object, **kwargs: object) -> None:
        kwargs.setdefault("allow_abbrev", False)
        kwargs.setdefault("formatter_class", _Formatter)
        super().__init__(*args, **kwargs)  # type: ignore[arg-type]

    def unknown_options(self, words: Iterable[str]) -> list[str]:
        """Return one sentence for each of `words` that is no option of this parser."""
        known = [name for name in self._option_string_actions if name.startswith("--")]
        sentences = []
        for word in words:
            name = word.split("=", 1)[0]
            if name.startswith("--") and len(name) > 2 and name not in known:
                sentences.append(f"there is no option {name}.{did_you_mean(name, known)}")
        return sentences

    def error(self, message: str) -> NoReturn:
        """Print what was wrong, what may have been meant, and where help is; exit with 2."""
        # A mistyped option is often the cause of "required" or "unrecognized": say that first.
        sentences = self.unknown_options(self.typed)
        if sentences:
            message = " ".join(sentences)
        self.exit(2, f"{self.prog}: error: {message}\nFor help: {self.prog} --help\n")


class _Formatter(argparse.HelpFormatter):
    def __init__(self, prog: str) -> None:
        # A fixed width: the reference in docs/ is generated from this very text.
        super().__init__(prog, max_help_position=30, width=96)


@dataclass(frozen=True)
class Command:
    """A command by name, known before anything of it is imported."""

    name: str
    help: str
    fill: Callable[[Parser, Sequence[str]], None]
    """`fill(parser, rest)`: add the arguments; `rest` is what was typed after the name."""


def first_positional(words: Sequence[str]) -> int | None:
    """Return the index of the first word that is no option, or None."""
    for index, word in enumerate(words):
        if not word.startswith("-"):
            return index
    return None


def add_commands(
    parser: Parser, commands: Sequence[Command], words: Sequence[str], title: str
) -> None:
    """Add `commands` to `parser` and fill in the one that `words` names.

    An unknown command is a usage error that names the nearest one.
    """
    parser.typed = words
    by_name: Mapping[str, Command] = {command.name: command for command in commands}
    at = first_positional(words)
    named = None if at is None else words[at]
    if named is not None and named not in by_name:
        parser.typed = ()
        parser.error(
            f"there is no {title} {named!r}.{did_you_mean(named, by_name)} "
            f"There are: {', '.join(by_name)}."
        )
    group = parser.add_subparsers(
        title=f"{title}s", metavar=title.upper(), required=True, parser_class=Parser
    )
    for command in commands:
        child = group.add_parser(command.name, help=command.help, description=command.help)
        if command.name == named and at is not None:
            rest = words[at + 1 :]
            child.typed = rest
            # The innermost parser, of `basis build` say, speaks of what it cannot read.
            child.set_defaults(speaker=child)
            command.fill(child, rest)
    if at is not None:
        # What follows the name belongs to the command.
        parser.typed = words[:at]
