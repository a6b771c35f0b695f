"""Where the numbers of a delimited text stand: delimiter, header, data lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from brdfit.errors import CorruptFile, NotThisFormat, UsageError
from brdfit.formats.columns import guess_columns
from brdfit.formats.text import NumberedLine, TextFile, parse_number, split_fields

__all__ = ["LAYOUT_OPTIONS", "Layout", "layout_of", "looks_delimited"]

LAYOUT_OPTIONS = ("delimiter", "header", "comment", "decimal")
"""Options that tell how to split the text; all are found out if left away."""

_DELIMITERS: tuple[str | None, ...] = (";", "\t", ",", None)
_BY_NAME = {"tab": "\t", "\\t": "\t", "space": None, "comma": ",", "semicolon": ";"}
_LOOK_AT = 50
_FEWEST = 4  # three angles and a value; constants may stand for some


@dataclass(frozen=True)
class Layout:
    """How the text splits into columns and rows."""

    delimiter: str | None
    """None = runs of blanks."""
    decimal: str
    names: tuple[str, ...]
    """Column names; "1", "2", ... where the file names none."""
    has_names: bool
    lines: tuple[NumberedLine, ...]
    """The data lines."""
    notes: tuple[str, ...]


def looks_delimited(text: str, fewest: int = _FEWEST) -> bool:
    """Whether a text has a line that splits into at least `fewest` numbers."""
    lines = [line for line in text.replace("\r", "\n").split("\n") if line.strip()]
    return any(
        _count_numbers(line, delimiter) >= fewest
        for line in lines[:200]
        for delimiter in _DELIMITERS
    )


def layout_of(text: TextFile, options: Mapping[str, Any]) -> Layout:
    """Find delimiter, header and data lines of `text`; `options` hold where given."""
    comment = str(options.get("comment", "#"))
    filled = [(number, line) for number, line in text.lines if line.strip()]
    data = [item for item in filled if not (comment and item[1].lstrip().startswith(comment))]
    if not data:
        raise CorruptFile(
            f"{text.name}: found {len(filled)} lines that are not blank, all of them comments, "
            f"but at least one row of numbers was expected."
        )
    delimiter = _delimiter(options, [line for _, line in data[:_LOOK_AT]])
    decimal, notes = _decimal(options, delimiter, [line for _, line in data[:_LOOK_AT]])
    rows = data[1:] if len(data) > 1 else data
    widths = Counter(len(split_fields(line, delimiter)) for _, line in rows[:_LOOK_AT])
    width = widths.most_common(1)[0][0]
    header = split_fields(data[0][1], delimiter)
    if _is_header(options.get("header"), header, width):
        if len(header) != width and not (len(header) == width + 1 and not header[-1]):
            raise NotThisFormat(
                f"{text.name}, line {data[0][0]}: the header names {len(header)} columns but the "
                f"rows have {width} fields; correct the header, or remove it and declare the "
                f"columns by position"
            )
        names = tuple(name or str(place) for place, name in enumerate(header[:width], start=1))
        return Layout(delimiter, decimal, names, True, tuple(data[1:]), notes)
    named = _names_in_comment(filled, data[0][0], comment, delimiter, width)
    if named is not None:
        return Layout(delimiter, decimal, named, True, tuple(data), notes)
    names = tuple(str(place) for place in range(1, width + 1))
    return Layout(delimiter, decimal, names, False, tuple(data), notes)


def _delimiter(options: Mapping[str, Any], lines: Sequence[str]) -> str | None:
    given = options.get("delimiter")
    if given is not None:
        delimiter = _BY_NAME.get(str(given), str(given))
        if delimiter is not None and (len(delimiter) != 1 or delimiter in '"\n\r'):
            raise UsageError(
                f"delimiter: found {given!r} but expected one character, 'tab' or 'space'."
            )
        return None if delimiter == " " else delimiter
    scores = {d: sum(_count_numbers(line, d) for line in lines) for d in _DELIMITERS}
    return max(scores, key=lambda delimiter: scores[delimiter])


def _decimal(
    options: Mapping[str, Any], delimiter: str | None, lines: Sequence[str]
) -> tuple[str, tuple[str, ...]]:
    given = options.get("decimal")
    if given is not None:
        if given not in (".", ",") or given == delimiter:
            raise UsageError(
                f"decimal: found {given!r} but expected '.' or ',', not the delimiter."
            )
        return str(given), ()
    fields = [field for line in lines for field in split_fields(line, delimiter)]
    commas = sum(parse_number(f) is None and _is_number(f.replace(",", ".")) for f in fields)
    points = sum("." in field and _is_number(field) for field in fields)
    if delimiter in (";", "\t") and commas and not points:
        return ",", ("decimal commas recognised",)
    return ".", ()


def _is_header(given: Any, fields: Sequence[str], width: int) -> bool:
    if given is not None:
        return str(given).strip().lower() in ("true", "yes", "1", "on")
    words = sum(parse_number(field) is None for field in fields)
    if len(fields) == width and not isinstance(guess_columns(fields), str):
        return True
    # a first row with one damaged field is a row; a header of wavelengths has few words
    return 2 * words > len(fields) or (words >= 3 and parse_number(fields[0]) is None)


def _names_in_comment(
    filled: Sequence[NumberedLine],
    first_row: int,
    comment: str,
    delimiter: str | None,
    width: int,
) -> tuple[str, ...] | None:
    """Column names in the last comment before the rows, if they can be understood."""
    before = [line for number, line in filled if number < first_row]
    if not before or not comment:
        return None
    fields = split_fields(before[-1].lstrip().lstrip(comment).strip(), delimiter)
    if len(fields) != width or isinstance(guess_columns(fields), str):
        return None
    return tuple(fields)


def _count_numbers(line: str, delimiter: str | None) -> int:
    if delimiter is not None and delimiter not in line:
        return 0
    fields = line.split(delimiter)
    return sum(_is_number(f) or (delimiter in (";", "\t") and _comma(f)) for f in fields)


def _is_number(field: str) -> bool:
    return bool(field.strip()) and parse_number(field) is not None


def _comma(field: str) -> bool:
    return field.count(",") == 1 and _is_number(field.replace(",", "."))
