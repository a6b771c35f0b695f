"""Read CUReT: values of a material in one row, the 205 directions in table.txt beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import CorruptFile, FormatError, UsageError
from brdfit.formats.text import parse_rows, read_text, split_fields
from brdfit.geometry import directions_from_spherical
from brdfit.samples import Flag, Samples

__all__ = ["CONVENTION", "DIRECTIONS", "read_samples"]

DIRECTIONS = 205
"""Pairs of directions that every material was measured at."""

CONVENTION = (
    "table.txt holds number, theta_v phi_v toward the detector, theta_i phi_i toward the "
    "light, radians; values are f_r in 1/sr averaged over red, green and blue"
)

_TABLE = "table.txt"


def read_samples(
    path: Path, *, material: int | str | None = None, directions_file: str | Path | None = None
) -> Samples:
    """Read one material.

    Parameters: `material`, its number (the first field of its row; may be left out where
    the file has one); `directions_file`, where the directions are, `table.txt` beside `path`
    if left out.

    The row of a sample is its number in the table of directions.
    """
    text = read_text(path)
    data = {
        fields[0]: (number, line)
        for number, line in text.lines
        if (fields := split_fields(line, None))
    }
    key = _material_of(text.name, material, list(data))
    number, line = data[key]
    cells, readable, _ = parse_rows([(number, line)], None, DIRECTIONS + 1)
    if not readable.all():
        found = len(line.split())
        raise CorruptFile(
            f"{text.name}, line {number}: material {key} has {found} fields but "
            f"{DIRECTIONS + 1} numbers are needed (its number and {DIRECTIONS} values). "
            f"The file looks truncated or damaged; copy it again."
        )
    beside = Path(directions_file) if directions_file is not None else path.with_name(_TABLE)
    angles, understood = _directions(beside, text.name)
    theta_v, phi_v, theta_i, phi_i = angles.T
    notes = [f"material {key} of {len(data)}", f"directions from {beside.name}"]
    return Samples(
        wi=directions_from_spherical(theta_i, phi_i),
        wo=directions_from_spherical(theta_v, phi_v),
        value=cells[0, 1:, None],
        flags=np.where(understood, 0, int(Flag.UNREADABLE)),
        rows=np.arange(1, DIRECTIONS + 1),
        source=text.source("curet", CONVENTION, notes, {"material": key}),
    )


def _material_of(name: str, material: int | str | None, known: list[str]) -> str:
    allowed = known[0] if len(known) == 1 else f"{known[0]} to {known[-1]}"
    if material is None:
        if len(known) == 1:
            return known[0]
        raise UsageError(
            f"{name}: holds {len(known)} materials; say which with material=..., on the "
            f"command line --material ({allowed})."
        )
    if str(material) not in known:
        raise UsageError(f"{name}: has no material {material!r}; it has {allowed}.")
    return str(material)


def _directions(path: Path, values: str) -> tuple[FloatArray, BoolArray]:
    if not path.is_file():
        raise FormatError(
            f"{path.name}: not found, but {values} needs the table of CUReT's {DIRECTIONS} "
            f"directions. Put table.txt beside it, or name it with directions_file=...."
        )
    table = read_text(path)
    data = [item for item in table.lines if item[1].strip()]
    cells, readable, _ = parse_rows(data, None, 5)
    if len(data) != DIRECTIONS:
        raise CorruptFile(
            f"{table.name}: found {len(data)} directions but CUReT has {DIRECTIONS}. The file "
            f"looks truncated; copy it again."
        )
    return cells[:, 1:], readable
