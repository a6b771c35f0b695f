"""Read ALTA text: #DIM inputs outputs, #PARAM_IN, #PARAM_OUT, rows of numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, IntArray
from brdfit.errors import CorruptFile, FormatError
from brdfit.formats.alta._parametrisation import OPEN, PARAMETRISATIONS
from brdfit.formats.text import NumberedLine, TextFile, name_lines, parse_rows, read_text
from brdfit.samples import Flag, Samples

__all__ = ["read_samples"]

_CHANNELS = {"RGB_COLOR": ("R", "G", "B"), "XYZ_COLOR": ("X", "Y", "Z")}
_OUT = ("INV_STERADIAN", "INV_STERADIAN_COSINE_FACTOR", "RGB_COLOR", "XYZ_COLOR")
# columns that follow the values of each output for a kind of vertical segment
_SEGMENT_COLUMNS = {"0": 0, "1": 1, "2": 2}


@dataclass(frozen=True)
class _Header:
    inputs: int
    outputs: int
    param_in: str
    param_out: str
    width: int
    fields: dict[str, str]


def read_samples(path: Path) -> Samples:
    """Read the samples of an ALTA text file.

    Raises `FormatError` naming a parametrisation that has no directions, and `CorruptFile`
    where the header is incomplete. Rows that cannot be parsed are flagged.
    """
    text = read_text(path)
    data = [item for item in text.lines if item[1].strip() and not item[1].startswith("#")]
    header = _header_of(text, data)
    if not data:
        raise CorruptFile(f"{text.name}: the header is there, but no row of numbers follows it.")
    longest = max(len(line.split()) for _, line in data)
    if header.width > longest:
        raise CorruptFile(
            f"{text.name}: none of {len(data)} rows holds {header.width} numbers, as "
            f"#DIM {header.inputs} {header.outputs} says; the longest has {longest}."
        )
    cells, readable, lines = parse_rows(data, None, header.width)
    if not readable.any():
        raise CorruptFile(
            f"{text.name}: none of {len(data)} rows holds {header.width} numbers, as "
            f"#DIM {header.inputs} {header.outputs} says; line {lines[0]} has "
            f"{len(data[0][1].split())}."
        )
    wi, wo = PARAMETRISATIONS[header.param_in][1](cells[:, : header.inputs])
    value = cells[:, header.inputs : header.inputs + header.outputs]
    if header.param_out == "INV_STERADIAN_COSINE_FACTOR":
        value = value / np.where(wo[:, 2] > 0.0, wo[:, 2], 1.0)[:, None]
    convention = f"{header.param_in}, radians; values are {header.param_out} taken as f_r, 1/sr"
    return Samples(
        wi=wi,
        wo=wo,
        value=value,
        channels=_CHANNELS.get(header.param_out, ()) if header.outputs == 3 else (),
        flags=np.where(readable, 0, int(Flag.UNREADABLE)),
        rows=lines,
        source=text.source("alta", convention, _notes(header, readable, lines), header.fields),
    )


def _notes(header: _Header, readable: BoolArray, lines: IntArray) -> list[str]:
    notes = [OPEN[header.param_in]] if header.param_in in OPEN else []
    if header.width > header.inputs + header.outputs:
        notes.append("vertical segments (#VS) are not read: they are bounds, no deviation")
    if not readable.all():
        notes.append(name_lines("rows that could not be read", lines[~readable]))
    return notes


def _header_of(text: TextFile, data: list[NumberedLine]) -> _Header:
    fields: dict[str, str] = {}
    for _, line in text.lines:
        if line.startswith("#"):
            words = line[1:].split(None, 1)
            if len(words) == 2:
                fields.setdefault(words[0], words[1].strip())
    if fields.get("FORMAT", "text") != "text":
        raise FormatError(f"{text.name}: is ALTA's binary variant; convert it to text with ALTA.")
    sizes = fields.get("DIM", "").split()
    if len(sizes) != 2 or not all(size.isdigit() and int(size) for size in sizes):
        raise CorruptFile(
            f"{text.name}: found #DIM {' '.join(sizes) or '(missing)'} but the numbers of inputs "
            f"and outputs were expected, such as #DIM 1 3."
        )
    inputs, outputs = int(sizes[0]), int(sizes[1])
    param_in = fields.get("PARAM_IN", "(missing)")
    param_out = fields.get("PARAM_OUT", "INV_STERADIAN")
    _check(text.name, param_in, param_out, inputs)
    segments = fields.get("VS", "").split()
    if any(kind not in _SEGMENT_COLUMNS for kind in segments):
        raise CorruptFile(f"{text.name}: #VS {' '.join(segments)} should be 0, 1 or 2 each.")
    width = inputs + outputs + sum(_SEGMENT_COLUMNS[kind] for kind in segments)
    return _Header(inputs, outputs, param_in, param_out, width, fields)


def _check(name: str, param_in: str, param_out: str, inputs: int) -> None:
    if param_in not in PARAMETRISATIONS:
        raise FormatError(
            f"{name}: #PARAM_IN is {param_in}, which does not determine the directions of an "
            f"isotropic measurement. Known: {', '.join(PARAMETRISATIONS)}. Convert it with ALTA."
        )
    if PARAMETRISATIONS[param_in][0] != inputs:
        raise CorruptFile(
            f"{name}: {param_in} has {PARAMETRISATIONS[param_in][0]} coordinates but #DIM says "
            f"{inputs}. One of the two lines is wrong."
        )
    if param_out not in _OUT:
        raise FormatError(
            f"{name}: #PARAM_OUT is {param_out}, which is no BRDF in 1/sr. "
            f"Known: {', '.join(_OUT)}."
        )
