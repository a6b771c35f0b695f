"""What a person may say of a file when it is read: the command line and the page ask the same.

Each is a keyword of `read_samples` and `read_table`; most are keys of a declaration of
columns (`brdfit.formats`), which a TOML file beside the data may hold as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from brdfit.errors import UsageError

__all__ = ["READING_OPTIONS", "ReadingOption", "plain_value", "typed_options"]


@dataclass(frozen=True)
class ReadingOption:
    """One thing that can be said of a file."""

    name: str
    help: str
    kind: Literal["word", "number", "flag", "choice"] = "word"
    choices: tuple[str, ...] = ()
    example: str = ""
    """What stands for the value in a usage line."""


READING_OPTIONS = (
    ReadingOption("format", "Format by name, in place of sniffing the content.", example="NAME"),
    ReadingOption(
        "directions",
        "Columns of the directions, by name or position, separated by commas: "
        "theta_i,phi_i,theta_o,phi_o or theta_h,theta_d,phi_d or six vector components.",
        example="COLUMNS",
    ),
    ReadingOption("values", "Columns of f_r in 1/sr, one for each channel.", example="COLUMNS"),
    ReadingOption("sigma", "Columns of the standard deviation of the values.", example="COLUMNS"),
    ReadingOption(
        "coordinates",
        "What the direction columns are, where their number does not tell.",
        "choice",
        ("spherical", "relative", "half_difference", "vectors"),
    ),
    ReadingOption(
        "light",
        "Which of the two directions points toward the light (default: first).",
        "choice",
        ("first", "second"),
    ),
    ReadingOption(
        "cosine_weighted",
        "Values are f_r times the cosine of the detector's polar angle.",
        "flag",
    ),
    ReadingOption(
        "wavelengths",
        "Wavelength of each channel in nm, separated by commas.",
        example="NM,...",
    ),
    ReadingOption("channels", "Names of the channels, separated by commas.", example="NAMES"),
    ReadingOption("flags", "Column that marks wrong measurements (not 0).", example="COLUMN"),
    ReadingOption("material", "Which material, in a file that holds several.", example="NAME"),
    ReadingOption(
        "wavelength",
        "Read only this wavelength, from a file that holds several (NIST).",
        "number",
        example="NM",
    ),
    ReadingOption("angles", "Unit of the angles.", "choice", ("degrees", "radians")),
)
"""All of them, as a usage page lists them."""


def typed_options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a reader from their texts, as a form or an address holds them.

    A name that is not one of `READING_OPTIONS` belongs to one reader alone, which says what
    it knows; its text is taken by `plain_value`. What is no text stays as it is. Raises
    `UsageError` for a number that is none.
    """
    kinds = {option.name: option.kind for option in READING_OPTIONS}
    return {
        name: _typed(name, value, kinds.get(name)) if isinstance(value, str) else value
        for name, value in given.items()
    }


def plain_value(word: str) -> Any:
    """Return a word as true, false, none or a number where it is one, else as it stands."""
    words: dict[str, Any] = {"true": True, "false": False, "none": None}
    if word.lower() in words:
        return words[word.lower()]
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word


def _typed(name: str, text: str, kind: str | None) -> Any:
    if kind is None:
        return plain_value(text)
    if kind == "flag":
        return text.lower() not in ("", "false", "no", "0", "off")
    if kind != "number":
        return text
    try:
        return float(text)
    except ValueError as error:
        raise UsageError(f"{name}: found {text!r} but expected a number.") from error
