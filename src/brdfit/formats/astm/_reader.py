"""Read ASTM E1392: header lines KEY value, VARS names the columns, rows with commas.

The specular direction of the files that Cornell published is at phi_s = phi_i + pi: the
azimuths are those of the two directions in one frame. Exact zeros near grazing and below
430 nm are the noise floor of the instrument; they stay as values and `Samples` flags them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from brdfit.errors import CorruptFile, NotThisFormat
from brdfit.formats.columns import guess_columns
from brdfit.formats.declaration import Column, Declaration, position_of, samples_from
from brdfit.formats.text import NumberedLine, TextFile, name_lines, parse_rows, read_text
from brdfit.samples import Samples

__all__ = ["CONVENTION", "read_samples"]

CONVENTION = (
    "theta_i phi_i toward the light, theta_s phi_s toward the detector, radians, specular at "
    "phi_s - phi_i = pi; values are f_r in 1/sr"
)


@dataclass(frozen=True)
class _Header:
    fields: dict[str, str]
    names: tuple[str, ...]
    points: int | None
    points_line: int
    rows: tuple[NumberedLine, ...]


def read_samples(path: Path, *, angles: str = "radians") -> Samples:
    """Read the samples of an ASTM E1392 file.

    `angles`: "radians" as Cornell wrote them, or "degrees". Raises `CorruptFile` where
    NUM_POINTS and the number of rows disagree; a row that cannot be parsed is flagged.
    """
    text = read_text(path)
    header = _header_of(text)
    guess = guess_columns(header.names)
    if isinstance(guess, str) or guess.coordinates != "spherical":
        raise CorruptFile(
            f"{text.name}: VARS names the columns {', '.join(header.names)}, but theta_i, phi_i, "
            f"theta_s, phi_s and columns such as 400nm were expected. Rename them in VARS."
        )
    _check_count(text.name, header)
    cells, readable, lines = parse_rows(header.rows, ",", len(header.names))
    notes = [f"{key}: {header.fields[key]}" for key in ("LAB_COMMENTS",) if key in header.fields]
    if guess.ignored:
        notes.append(f"columns not read: {', '.join(guess.ignored)}")
    if not readable.all():
        notes.append(name_lines("rows that could not be read", lines[~readable]))
    declaration = Declaration(
        directions=guess.directions, values=guess.values, sigma=guess.sigma, angles=angles
    )
    convention = CONVENTION.replace("radians", angles)
    names: dict[Column, str] = {column: header.names[int(column) - 1] for column in guess.values}
    return samples_from(
        declaration,
        lambda column: cells[:, position_of(column, header.names, text.name)],
        names,
        readable,
        lines,
        text.source("astm", convention, notes, header.fields),
    )


def _header_of(text: TextFile) -> _Header:
    fields: dict[str, str] = {}
    points_line = 0
    for place, (number, line) in enumerate(text.lines):
        key, _, value = line.strip().partition(" ")
        value = value.strip()
        if key.startswith("VARS"):
            names = tuple(name.strip() for name in line.strip()[4:].split(","))
            points = fields.get("NUM_POINTS")
            if points is not None and not points.isdigit():
                raise CorruptFile(
                    f"{text.name}, line {points_line}: NUM_POINTS is {points!r} but the number "
                    f"of rows was expected."
                )
            rows = tuple(item for item in text.lines[place + 1 :] if item[1].strip())
            count = None if points is None else int(points)
            return _Header(fields, names, count, points_line, rows)
        if key == "NUM_POINTS":
            points_line = number
        if key:
            fields[key] = f"{fields[key]}; {value}" if key in fields else value
    raise NotThisFormat(
        f"{text.name}: no line VARS names the columns of this ASTM E1392 file; the header is "
        f"damaged, or the columns must be declared (format='delimited')"
    )


def _check_count(name: str, header: _Header) -> None:
    if not header.rows:
        raise CorruptFile(f"{name}: the header is there, but no row of measurements follows it.")
    if header.points is not None and header.points != len(header.rows):
        last = header.rows[-1][0]
        fewer = len(header.rows) < header.points
        raise CorruptFile(
            f"{name}, line {header.points_line}: NUM_POINTS says {header.points} but "
            f"{len(header.rows)} rows follow (the last is line {last}). "
            f"{'The file looks truncated' if fewer else 'Rows were added'}: copy it again, or "
            f"correct NUM_POINTS to use the rows that are there."
        )
