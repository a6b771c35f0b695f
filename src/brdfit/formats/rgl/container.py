"""The container of RGL's measurements: named arrays in one file ("tensor file").

    bytes 0-11   tensor_file and a zero byte
    bytes 12-13  version: 1, 0
    bytes 14-17  number of fields, uint32
    then for each field
        uint16 length of the name, the name (UTF-8), uint16 number of dimensions,
        uint8 type, uint64 offset of the data from the start of the file,
        uint64 for each dimension
    then the data, row-major, little-endian

Every size is held against the length of the file before anything is allocated, so that a
damaged header costs neither time nor memory.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from brdfit.errors import CorruptFile

__all__ = ["MAGIC", "read_fields", "written_fields"]

MAGIC = b"tensor_file\0"

_VERSION = (1, 0)
_TYPES = {
    1: "u1",
    2: "i1",
    3: "<u2",
    4: "<i2",
    5: "<u4",
    6: "<i4",
    7: "<u8",
    8: "<i8",
    9: "<f2",
    10: "<f4",
    11: "<f8",
}
# A field's entry in the header takes at least this much: 2 + 0 + 2 + 1 + 8.
_SMALLEST_ENTRY = 13
_MOST_DIMENSIONS = 16


@dataclass(frozen=True)
class _Entry:
    name: str
    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]

    @property
    def end(self) -> int:
        return self.offset + math.prod(self.shape) * self.dtype.itemsize


def read_fields(content: bytes, name: str) -> dict[str, npt.NDArray[Any]]:
    """Return the fields of a whole file as read-only arrays over `content`.

    `name` is the file's name for messages. Raises `CorruptFile` for the first condition
    that does not hold.
    """
    cursor = _Cursor(content, name)
    if not content.startswith(MAGIC):
        raise CorruptFile(
            f"{name}: starts with {content[:12]!r} but a tensor file starts with {MAGIC!r}. "
            f"The suffix .bsdf is also used by Zemax and LightTools for text."
        )
    cursor.position = len(MAGIC)
    version = cursor.take("<2B", "the version")
    if version != _VERSION:
        raise CorruptFile(
            f"{name}: found version {version[0]}.{version[1]} of the container but only "
            f"{_VERSION[0]}.{_VERSION[1]} is known."
        )
    (count,) = cursor.take("<I", "the number of fields")
    room = (len(content) - cursor.position) // _SMALLEST_ENTRY
    if count > room:
        raise CorruptFile(
            f"{name}: the header announces {count} fields but the file of {len(content):,} bytes "
            f"has room for {room} at most. The header is damaged; fetch the file again."
        )
    entries = [cursor.entry(index) for index in range(count)]
    return _arrays(content, entries, cursor.position, name)


def written_fields(fields: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Return the whole file that holds `fields`, in their order; `read_fields` undoes it."""
    codes = {np.dtype(kind): code for code, kind in _TYPES.items()}
    entries = {name: name.encode("utf-8") for name in fields}
    header_end = len(MAGIC) + struct.calcsize("<2BI")
    for name, raw in entries.items():
        header_end += _SMALLEST_ENTRY + len(raw) + 8 * fields[name].ndim
    header = bytearray(MAGIC + struct.pack("<2BI", *_VERSION, len(fields)))
    data = bytearray()
    for name, raw in entries.items():
        array = np.ascontiguousarray(fields[name])
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        header += struct.pack("<H", len(raw)) + raw
        header += struct.pack("<HBQ", array.ndim, codes[little.dtype], header_end + len(data))
        header += struct.pack(f"<{array.ndim}Q", *array.shape)
        data += little.tobytes()
    return bytes(header + data)


def _arrays(
    content: bytes, entries: list[_Entry], header_end: int, name: str
) -> dict[str, npt.NDArray[Any]]:
    fields: dict[str, npt.NDArray[Any]] = {}
    for entry in entries:
        if entry.name in fields:
            raise CorruptFile(f"{name}: the field {entry.name!r} occurs twice.")
        if entry.offset < header_end:
            raise CorruptFile(
                f"{name}: the data of field {entry.name!r} start at byte {entry.offset:,}, inside "
                f"the header, which ends at byte {header_end:,}. The header is damaged."
            )
        if entry.end > len(content):
            raise CorruptFile(
                f"{name}: field {entry.name!r} of shape {entry.shape} ends at byte "
                f"{entry.end:,} but the file has {len(content):,} bytes. It looks truncated; "
                f"fetch it again."
            )
        count = math.prod(entry.shape)
        if count == 0:
            raise CorruptFile(
                f"{name}: field {entry.name!r} has the shape {entry.shape}, which holds nothing."
            )
        flat = np.frombuffer(content, entry.dtype, count, entry.offset)
        fields[entry.name] = flat.reshape(entry.shape)
    return fields


@dataclass
class _Cursor:
    content: bytes
    name: str
    position: int = 0

    def take(self, layout: str, what: str) -> tuple[Any, ...]:
        """Return the next values of a `struct` layout, or say that the file ends there."""
        return struct.unpack(layout, self.bytes(struct.calcsize(layout), what))

    def bytes(self, count: int, what: str) -> bytes:
        piece = self.content[self.position : self.position + count]
        if len(piece) < count:
            raise CorruptFile(
                f"{self.name}: ends at byte {len(self.content):,} in the middle of the header, "
                f"where {what} was expected. The file is truncated; fetch it again."
            )
        self.position += count
        return piece

    def entry(self, index: int) -> _Entry:
        """Read one field's entry of the header."""
        where = f"field {index + 1}"
        (length,) = self.take("<H", f"the length of the name of {where}")
        raw = self.bytes(length, f"the name of {where}")
        try:
            field = raw.decode("utf-8")
        except UnicodeDecodeError as error:
            raise CorruptFile(f"{self.name}: the name of {where} is {raw[:40]!r}.") from error
        where = f"field {field!r}"
        (n_dimensions,) = self.take("<H", f"the number of dimensions of {where}")
        code, offset = self.take("<BQ", f"the type and offset of {where}")
        if code not in _TYPES:
            raise CorruptFile(
                f"{self.name}: {where} has the type code {code} but the codes are 1 to 11 "
                f"(unsigned and signed integers, floats)."
            )
        if n_dimensions > _MOST_DIMENSIONS:
            raise CorruptFile(
                f"{self.name}: {where} has {n_dimensions} dimensions but at most "
                f"{_MOST_DIMENSIONS} make sense. The header is damaged."
            )
        shape = self.take(f"<{n_dimensions}Q", f"the shape of {where}")
        return _Entry(field, np.dtype(_TYPES[code]), offset, tuple(shape))
