"""The measurements in a workbook: a column each, over as many sheets as 255 columns need."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import CorruptFile, MissingExtra, NotThisFormat
from brdfit.files import sha256_of_bytes

__all__ = ["Workbook", "read_workbook"]

_LABELS = ("Azimuth", "Incidence", "Receive", "RT")
_LABEL_COLUMN = 0
_MOST_LABEL_ROWS = 64  # further down there is a spectrum
_METADATA = ("Method", "Date", "Illuminant.", "Observer.", "Model ID", "Technician")


@dataclass(frozen=True)
class Workbook:
    """What a file holds, in the order of its columns."""

    name: str
    sha256: str
    angles: FloatArray
    """(n, 3) Azimuth, Incidence, Receive in degrees; NaN where a cell is no number."""
    rt: FloatArray
    """(n,) the instrument's RT, a ratio to its white standard."""
    columns: IntArray
    """(n,) 1-based number of the column, counted over all sheets, labels left out."""
    metadata: dict[str, str]


def read_workbook(path: Path) -> Workbook:
    """Read the measurements of an `.xls` file.

    Raises `NotThisFormat` for a workbook without the labels of the instrument, `CorruptFile`
    for one that cannot be read, `MissingExtra` without xlrd.
    """
    content = path.read_bytes()
    parts: list[FloatArray] = []
    metadata: dict[str, str] = {}
    for sheet in _sheets(content, path.name):
        rows = _labelled_rows(sheet)
        if not set(_LABELS) <= set(rows):
            continue
        parts.append(np.array([_numbers(sheet, rows[label]) for label in _LABELS]).T)
        metadata = metadata or _metadata(sheet, rows)
    if not parts or not sum(map(len, parts)):
        raise NotThisFormat(
            f"{path.name}: no sheet of this workbook has rows named {', '.join(_LABELS)} in its "
            f"first column, as the RT-300S writes them; export other tables as CSV"
        )
    cells = np.concatenate(parts)
    return Workbook(
        name=path.name,
        sha256=sha256_of_bytes(content),
        angles=cells[:, :3],
        rt=cells[:, 3],
        columns=np.arange(1, len(cells) + 1),
        metadata=metadata,
    )


def _sheets(content: bytes, name: str) -> Iterator[Any]:
    try:
        import xlrd
    except ImportError as error:
        raise MissingExtra("xlrd", "instruments", "Reading .xls of the RT-300S") from error
    try:
        book = xlrd.open_workbook(file_contents=content, logfile=io.StringIO(), on_demand=True)
        yield from (book.sheet_by_index(index) for index in range(book.nsheets))
    except GeneratorExit:
        raise
    except Exception as error:  # a damaged file trips xlrd in too many ways to name
        raise CorruptFile(
            f"{name}: is not a readable .xls workbook ({type(error).__name__}: {error}). It looks "
            f"truncated or damaged; export or copy it again."
        ) from error


def _labelled_rows(sheet: Any) -> dict[str, int]:
    """Return label -> row of the first column; of a label that occurs twice the first."""
    rows: dict[str, int] = {}
    if sheet.ncols:
        for row in range(min(sheet.nrows, _MOST_LABEL_ROWS)):
            rows.setdefault(str(sheet.cell_value(row, _LABEL_COLUMN)).strip(), row)
    return rows


def _numbers(sheet: Any, row: int) -> list[float]:
    cells = (sheet.cell_value(row, column) for column in range(_LABEL_COLUMN + 1, sheet.ncols))
    return [float(cell) if isinstance(cell, int | float) else np.nan for cell in cells]


def _metadata(sheet: Any, rows: dict[str, int]) -> dict[str, str]:
    found: dict[str, str] = {}
    if sheet.ncols > _LABEL_COLUMN + 1:
        for label in _METADATA:
            if label in rows:
                text = str(sheet.cell_value(rows[label], _LABEL_COLUMN + 1)).strip()
                if text:
                    found[label.rstrip(".")] = text
    return found
