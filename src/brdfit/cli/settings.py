"""Options of a method: made from the fields of its frozen dataclass.

The type of a field decides how its option is read, its default is the option's default,
and the string under the field (or `metadata["help"]`) is the option's help. A field is not
an option if its type cannot be typed in one word.
"""

from __future__ import annotations

import argparse
import dataclasses
import types
import typing
from collections.abc import Callable, Collection
from typing import Any

from brdfit.errors import UsageError
from brdfit.report.field_help import field_help

__all__ = ["add_settings", "field_help", "given_settings", "option_name", "pick"]

_PREFIX = "setting:"
_PLAIN: dict[type, Callable[[str], Any]] = {int: int, float: float, str: str}


def option_name(field_name: str) -> str:
    """Return the option of a field: `error_metric` -> `--error-metric`."""
    return "--" + field_name.replace("_", "-")


def add_settings(
    parser: argparse._ActionsContainer, settings: type, skip: Collection[str] = ()
) -> None:
    """Add one option for each field of the dataclass `settings` but those in `skip`."""
    hints = typing.get_type_hints(settings)
    texts = field_help(settings)
    for item in dataclasses.fields(settings):
        keywords = _option(hints[item.name])
        if item.name in skip or keywords is None:
            continue
        default = _default(item)
        text = _first_paragraph(item.metadata.get("help", texts.get(item.name, "")))
        shown = "" if default is None else f" (default: {_shown(default)})"
        parser.add_argument(
            option_name(item.name),
            dest=_PREFIX + item.name,
            default=argparse.SUPPRESS,
            help=(text + shown).replace("%", "%%").strip(),
            **keywords,
        )


def given_settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the fields whose options were typed, by field name."""
    return {
        name.removeprefix(_PREFIX): value
        for name, value in vars(arguments).items()
        if name.startswith(_PREFIX)
    }


def _first_paragraph(text: str) -> str:
    return " ".join(text.split("\n\n")[0].split())


def _default(item: dataclasses.Field[Any]) -> object:
    if item.default is not dataclasses.MISSING:
        return item.default
    if item.default_factory is not dataclasses.MISSING:
        return item.default_factory()
    return None


def _shown(default: object) -> str:
    if isinstance(default, bool):
        return "on" if default else "off"
    return str(default)


def _option(hint: Any) -> dict[str, Any] | None:
    """Return how argparse reads a value of this type, or None if it cannot."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return _option_of_union([one for one in inner if one is not type(None)])
    if origin is typing.Literal:
        return {"choices": list(inner), "type": type(inner[0])}
    if hint is bool:
        return {"action": argparse.BooleanOptionalAction}
    if hint in _PLAIN:
        return {"type": _reader(hint), "metavar": hint.__name__.upper()}
    if origin is tuple and len(inner) == 2 and inner[1] is Ellipsis and inner[0] in _PLAIN:
        return {"type": _tuple_reader(inner[0]), "metavar": f"{inner[0].__name__.upper()},..."}
    return None


def _option_of_union(members: list[Any]) -> dict[str, Any] | None:
    options = [option for option in map(_option, members) if option is not None]
    if len(members) == 1 or not options:
        return options[0] if options else None
    # A number or a word: `float | Literal["auto"]`. The number is tried first.
    words = [word for one in members for word in typing.get_args(one)]
    plain = next((one for one in members if one in _PLAIN), str)

    def read(text: str) -> Any:
        return text if text in words else _reader(plain)(text)

    return {"type": read, "metavar": "|".join([plain.__name__.upper(), *map(str, words)])}


def _reader(plain: type) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            return _PLAIN[plain](text)
        except ValueError:
            kind = {"int": "a whole number", "float": "a number"}.get(plain.__name__, "a word")
            raise argparse.ArgumentTypeError(f"found {text!r} but expected {kind}") from None

    return read


def _tuple_reader(plain: type) -> Callable[[str], tuple[Any, ...]]:
    def read(text: str) -> tuple[Any, ...]:
        return tuple(_reader(plain)(part.strip()) for part in text.split(",") if part.strip())

    return read


def pick(name: str, known: dict[str, type]) -> str:
    """Return the key of `known` that `name` means, ignoring case, - and _.

    Raises `UsageError` with the allowed names.
    """
    from brdfit.cli.parser import did_you_mean

    def plain(word: str) -> str:
        return word.lower().replace("-", "").replace("_", "")

    for key, value in known.items():
        if plain(name) in (plain(key), plain(value.__name__)):
            return key
    raise UsageError(
        f"there is no method {name!r}.{did_you_mean(name, known)} There are: {', '.join(known)}."
    )
