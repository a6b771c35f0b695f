"""Options that say what the columns of a file mean; the same words as in a TOML sidecar."""

from __future__ import annotations

import argparse
from typing import Any

from brdfit.report.reading_options import READING_OPTIONS, ReadingOption, plain_value

__all__ = ["add_reading_options", "reading_options"]

_PREFIX = "read:"
_OTHERS = "other reader options"

_UNIT = "angles"


def add_reading_options(parser: argparse.ArgumentParser, title: str = "reading") -> None:
    """Add --format and the declaration of columns to `parser`."""
    group = parser.add_argument_group(
        title,
        "What the file is and what its columns mean. Needed only where the file does not say "
        "it; a TOML file beside the data (name.csv.toml) may say the same.",
    )
    for option in READING_OPTIONS:
        if option.name == _UNIT:
            continue  # --degrees and --radians
        word = "--" + option.name.replace("_", "-")
        dest = _PREFIX + option.name
        group.add_argument(word, dest=dest, default=argparse.SUPPRESS, **_keywords(option))
    unit = group.add_mutually_exclusive_group()
    for name in ("degrees", "radians"):
        unit.add_argument(
            f"--{name}",
            dest=_PREFIX + _UNIT,
            action="store_const",
            const=name,
            default=argparse.SUPPRESS,
            help=f"Angles are in {name}.",
        )
    group.add_argument(
        "--option",
        dest=_OTHERS,
        action="append",
        type=_named_value,
        default=argparse.SUPPRESS,
        metavar="NAME=VALUE",
        help="Any other option of the format's reader, such as delimiter=; or half=true; may be "
        "repeated. docs/formats.md lists them.",
    )


def _keywords(option: ReadingOption) -> dict[str, Any]:
    """Return what `add_argument` is told of an option, beside its name."""
    if option.kind == "flag":
        return {"action": "store_const", "const": True, "help": option.help}
    if option.kind == "choice":
        return {"choices": list(option.choices), "help": option.help}
    kind: dict[str, Any] = {"type": float} if option.kind == "number" else {}
    return {**kind, "metavar": option.example, "help": option.help}


def reading_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword options of `read_samples` and `read_table` that were typed."""
    given = {
        name.removeprefix(_PREFIX): value
        for name, value in vars(arguments).items()
        if name.startswith(_PREFIX)
    }
    return given | dict(getattr(arguments, _OTHERS, []))


def _named_value(text: str) -> tuple[str, Any]:
    """Return (name, value) of NAME=VALUE; numbers, true and false are read as such."""
    name, equals, word = text.partition("=")
    if not (name.strip() and equals):
        raise argparse.ArgumentTypeError(f"found {text!r} but expected NAME=VALUE")
    return name.strip(), plain_value(word)
