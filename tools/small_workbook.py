"""A minimal `.xls` workbook: cells of text and numbers, in BIFF8 within a compound document.

Enough for the tests of the readers: no library that still lives writes the format. After
Microsoft's [MS-XLS] and [MS-CFB].
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

__all__ = ["workbook"]

Cell = str | float | None

_SECTOR = 512
_END, _FREE, _FAT, _NONE = 0xFFFFFFFE, 0xFFFFFFFF, 0xFFFFFFFD, 0xFFFFFFFF
_SMALLEST_STREAM = 4096  # shorter ones live in another place


def workbook(sheets: Sequence[Sequence[Sequence[Cell]]]) -> bytes:
    """Return the bytes of a workbook; `sheets` are rows of cells, None = empty."""
    names = [f"Sheet{number}" for number in range(1, len(sheets) + 1)]
    bodies = [_sheet(rows) for rows in sheets]
    globals_size = len(_bof(5)) + len(_record(0x0A, b""))
    globals_size += sum(len(_bound_sheet(0, name)) for name in names)
    stream, offset = _bof(5), globals_size
    for name, body in zip(names, bodies, strict=True):
        stream += _bound_sheet(offset, name)
        offset += len(body)
    stream += _record(0x0A, b"") + b"".join(bodies)
    return _compound(stream)


def _record(kind: int, data: bytes) -> bytes:
    return struct.pack("<HH", kind, len(data)) + data


def _bof(kind: int) -> bytes:
    return _record(0x0809, struct.pack("<4H2I", 0x0600, kind, 0x0DBB, 0x07CC, 0x41, 0x06))


def _bound_sheet(offset: int, name: str) -> bytes:
    return _record(0x0085, struct.pack("<IHBB", offset, 0, len(name), 0) + name.encode("latin-1"))


def _sheet(rows: Sequence[Sequence[Cell]]) -> bytes:
    width = max(map(len, rows), default=0)
    body = _bof(0x10) + _record(0x0200, struct.pack("<2I3H", 0, len(rows), 0, width, 0))
    for y, row in enumerate(rows):
        for x, cell in enumerate(row):
            if isinstance(cell, str):
                text = cell.encode("latin-1")
                data = struct.pack("<3HHB", y, x, 0, len(text), 0) + text
                body += _record(0x0204, data)
            elif cell is not None:
                body += _record(0x0203, struct.pack("<3Hd", y, x, 0, cell))
    return body + _record(0x0A, b"")


def _compound(stream: bytes) -> bytes:
    """Wrap the stream "Workbook": header, one sector of FAT, one of directory, the stream."""
    stream = stream.ljust(_SMALLEST_STREAM, b"\0")
    stream = stream.ljust(-(-len(stream) // _SECTOR) * _SECTOR, b"\0")
    count = len(stream) // _SECTOR
    if count + 2 > _SECTOR // 4:
        raise ValueError(f"{len(stream)} bytes are more than a small workbook can hold")
    fat = [_FAT, _END, *range(3, count + 2), _END]
    fat += [_FREE] * (_SECTOR // 4 - len(fat))
    header = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(16)
    header += struct.pack("<5H6x", 0x3E, 3, 0xFFFE, 9, 6)
    header += struct.pack("<9I", 0, 1, 1, 0, _SMALLEST_STREAM, _END, 0, _END, 0)
    header += struct.pack("<I", 0) + struct.pack("<I", _FREE) * 108
    directory = _entry("Root Entry", 5, _NONE, 1, _END, 0)
    directory += _entry("Workbook", 2, _NONE, _NONE, 2, len(stream))
    return header + struct.pack("<128I", *fat) + directory.ljust(_SECTOR, b"\0") + stream


def _entry(name: str, kind: int, left: int, child: int, start: int, size: int) -> bytes:
    text = (name + "\0").encode("utf-16-le")
    entry = text.ljust(64, b"\0") + struct.pack("<HBB3I", len(text), kind, 1, left, _NONE, child)
    return entry + bytes(36) + struct.pack("<IQ", start, size)
