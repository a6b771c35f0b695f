"""Text files of numbers: decoded, split into numbered lines, parsed without losing a row.

Line numbers are those of an editor, 1-based. A row that cannot be parsed keeps its place:
its numbers are NaN and its mark says unreadable.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import CorruptFile
from brdfit.files import sha256_of_bytes
from brdfit.samples import Source

__all__ = [
    "NumberedLine",
    "TextFile",
    "decode_head",
    "name_lines",
    "parse_number",
    "parse_rows",
    "read_text",
    "split_fields",
]

NumberedLine = tuple[int, str]
"""(1-based line number, the line without its end)."""

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?|[+-]?(inf|infinity)", re.IGNORECASE)
_MISSING = frozenset({"", "nan", "+nan", "-nan", "na", "n/a", "null", "none"})
_CHUNK = 4096
_LONGEST_QUOTED = 100_000  # the csv module refuses longer fields
_CONTROL_SHARE = 0.05


@dataclass(frozen=True)
class TextFile:
    """A decoded file: what its lines are and the hash of its bytes."""

    name: str
    sha256: str
    lines: tuple[NumberedLine, ...]

    def source(
        self,
        format: str,
        convention: str,
        notes: Sequence[str] = (),
        metadata: dict[str, str] | None = None,
    ) -> Source:
        """Return the `Source` of what was read from this file."""
        return Source(
            name=self.name,
            format=format,
            sha256=self.sha256,
            convention=convention,
            notes=tuple(notes),
            metadata=metadata or {},
        )


def read_text(path: Path) -> TextFile:
    """Read a text file: UTF-8 (byte order mark or not), UTF-16 with its mark, else Latin-1."""
    content = path.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = content.decode("utf-16", errors="replace")
    else:
        if b"\0" in content:
            raise CorruptFile(
                f"{path.name}: found binary content (a zero byte at offset "
                f"{content.index(0):,}) but text was expected. Name its format with format=...."
            )
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("latin-1")
    # not str.splitlines: that also splits at form feeds and other marks, and miscounts
    lines = re.split(r"\r\n|\n|\r", text)
    return TextFile(path.name, sha256_of_bytes(content), tuple(enumerate(lines, start=1)))


def decode_head(head: bytes) -> str | None:
    """Return the first bytes of a file as text, or None where they are binary."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return head.decode("utf-16", errors="ignore")
    if head.startswith(b"\xef\xbb\xbf"):
        head = head[3:]
    control = sum(byte < 32 and byte not in b"\t\n\r\f\v" for byte in head)
    binary = b"\0" in head or control > _CONTROL_SHARE * len(head)
    return None if binary else head.decode("utf-8", errors="replace")


def parse_number(field: str) -> float | None:
    """Return the number in a field: NaN for a missing one, None for anything else."""
    field = field.strip()
    if _NUMBER.fullmatch(field):
        return float(field)
    return math.nan if field.lower() in _MISSING else None


def split_fields(line: str, delimiter: str | None) -> list[str]:
    """Split a line at `delimiter`, None = runs of blanks; quotes hold a field together."""
    if delimiter is None:
        return line.split()
    if '"' in line and len(line) < _LONGEST_QUOTED:
        # a quote that is left open is no reason to stop: the field is then no number
        with suppress(csv.Error):
            fields = next(csv.reader([line], delimiter=delimiter, strict=True))
            return [field.strip() for field in fields]
    return [field.strip() for field in line.split(delimiter)]


def parse_rows(
    lines: Sequence[NumberedLine],
    delimiter: str | None,
    width: int,
    columns: Sequence[int] | None = None,
    decimal: str = ".",
) -> tuple[FloatArray, BoolArray, IntArray]:
    """Return (cells, readable, line numbers) of data lines.

    Parameters: `width`, how many fields a row has; `columns`, the 0-based fields that are
    wanted (all); `decimal`, the decimal mark.

    Returns: cells (n, columns), NaN where missing; `readable` (n,) is False, and the whole
    row NaN, where the number of fields differs or a wanted field is no number.
    """
    wanted = list(range(width)) if columns is None else list(columns)
    texts = [line if decimal == "." else line.replace(decimal, ".") for _, line in lines]
    cells = np.full((len(texts), len(wanted)), np.nan)
    readable = np.zeros(len(texts), dtype=bool)
    for start in range(0, len(texts), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        quick = _parse_clean(texts[chunk], delimiter, width, wanted)
        if quick is None:
            for row, text in enumerate(texts[chunk], start=start):
                numbers = _parse_line(text, delimiter, width, wanted)
                if numbers is not None:
                    cells[row], readable[row] = numbers, True
        else:
            cells[chunk], readable[chunk] = quick, True
    return cells, readable, np.array([number for number, _ in lines], dtype=np.int64)


def name_lines(what: str, numbers: IntArray, most: int = 10) -> str:
    """Return "what: 3 (lines 4, 7, 9)", the list cut after `most`."""
    shown = ", ".join(str(number) for number in numbers[:most])
    return f"{what}: {len(numbers)} (lines {shown}{', ...' if len(numbers) > most else ''})"


def _parse_clean(
    texts: list[str], delimiter: str | None, width: int, wanted: list[int]
) -> FloatArray | None:
    """NumPy's parser, an order faster; None where any line wants a closer look."""
    if delimiter is None:
        regular = all(len(text.split()) == width for text in texts)
    else:
        regular = all(text.count(delimiter) == width - 1 for text in texts)
    if not regular or any('"' in text or "_" in text for text in texts):
        return None
    try:
        cells = np.loadtxt(
            texts, dtype=np.float64, delimiter=delimiter, comments=None, usecols=wanted, ndmin=2
        )
    except ValueError:
        return None
    return cells if cells.shape == (len(texts), len(wanted)) else None


def _parse_line(
    text: str, delimiter: str | None, width: int, wanted: list[int]
) -> list[float] | None:
    fields = split_fields(text, delimiter)
    while len(fields) > width and not fields[-1]:
        fields.pop()
    if len(fields) != width:
        return None
    numbers = [parse_number(fields[column]) for column in wanted]
    return None if None in numbers else [float(number) for number in numbers if number is not None]
