"""Options that say what the columns of a file mean; the same words as in a TOML sidecar."""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["add_reading_options", "reading_options"]

_PREFIX = "read:"
_OTHERS = "other reader options"


# Option -> keywords of `add_argument`; the destination is its name.
_OPTIONS: dict[str, dict[str, Any]] = {
    "--format": {
        "metavar": "NAME",
        "help": "Format by name, in place of sniffing the content.",
    },
    "--directions": {
        "metavar": "COLUMNS",
        "help": "Columns of the directions, by name or position, separated by commas: "
        "theta_i,phi_i,theta_o,phi_o or theta_h,theta_d,phi_d or six vector components.",
    },
    "--values": {
        "metavar": "COLUMNS",
        "help": "Columns of f_r in 1/sr, one for each channel.",
    },
    "--sigma": {
        "metavar": "COLUMNS",
        "help": "Columns of the standard deviation of the values.",
    },
    "--coordinates": {
        "choices": ["spherical", "relative", "half_difference", "vectors"],
        "help": "What the direction columns are, where their number does not tell.",
    },
    "--light": {
        "choices": ["first", "second"],
        "help": "Which of the two directions points toward the light (default: first).",
    },
    "--cosine-weighted": {
        "action": "store_const",
        "const": True,
        "help": "Values are f_r times the cosine of the detector's polar angle.",
    },
    "--wavelengths": {
        "metavar": "NM,...",
        "help": "Wavelength of each channel in nm, separated by commas.",
    },
    "--channels": {
        "metavar": "NAMES",
        "help": "Names of the channels, separated by commas.",
    },
    "--flags": {
        "metavar": "COLUMN",
        "help": "Column that marks wrong measurements (not 0).",
    },
    "--material": {
        "metavar": "NAME",
        "help": "Which material, in a file that holds several.",
    },
    "--wavelength": {
        "type": float,
        "metavar": "NM",
        "help": "Read only this wavelength, from a file that holds several (NIST).",
    },
}


def add_reading_options(parser: argparse.ArgumentParser, title: str = "reading") -> None:
    """Add --format and the declaration of columns to `parser`."""
    group = parser.add_argument_group(
        title,
        "What the file is and what its columns mean. Needed only where the file does not say "
        "it; a TOML file beside the data (name.csv.toml) may say the same.",
    )
    for name, keywords in _OPTIONS.items():
        dest = _PREFIX + name.removeprefix("--").replace("-", "_")
        group.add_argument(name, dest=dest, default=argparse.SUPPRESS, **keywords)
    unit = group.add_mutually_exclusive_group()
    for name in ("degrees", "radians"):
        unit.add_argument(
            f"--{name}",
            dest=_PREFIX + "angles",
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
    words: dict[str, Any] = {"true": True, "false": False, "none": None}
    if word.lower() in words:
        return name.strip(), words[word.lower()]
    for kind in (int, float):
        try:
            return name.strip(), kind(word)
        except ValueError:
            continue
    return name.strip(), word
