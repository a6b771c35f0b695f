"""Read delimited text: our own CSV exactly, any other by its declaration."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.formats.declaration import Column, Declaration, coerce, position_of, samples_from
from brdfit.formats.declared import declare
from brdfit.formats.delimited._layout import LAYOUT_OPTIONS, Layout, layout_of
from brdfit.formats.delimited._writer import OWN_PREFIX
from brdfit.formats.own import OwnHeader, own_source, samples_from_own
from brdfit.formats.sidecar import read_sidecar
from brdfit.formats.text import TextFile, name_lines, parse_rows, read_text
from brdfit.samples import Samples

__all__ = ["read_samples"]

_NAME = "delimited"


def read_samples(path: Path, **options: Any) -> Samples:
    """Read samples; options are those of `Declaration` and `LAYOUT_OPTIONS`.

    A TOML sidecar may hold the same keys; options win. Rows that cannot be parsed become
    samples without directions and values, flagged `UNREADABLE`; `rows` are line numbers.
    """
    text = read_text(path)
    given, sidecar = read_sidecar(path)
    declared = {**given, **{key: value for key, value in options.items() if value is not None}}
    own = _own_header(text)
    if own is not None and not declared:
        return _read_own(text, own)
    layout_options = {key: declared.pop(key) for key in LAYOUT_OPTIONS if key in declared}
    where = sidecar if sidecar and not options else path.name
    declared = {key: coerce(key, value, where) for key, value in declared.items()}
    layout = layout_of(text, layout_options)
    table = _Columns(layout, path.name)
    declaration, notes = declare(path.name, layout.names, declared, table.take)
    if sidecar:
        notes.insert(0, f"columns declared in {sidecar}")
    return _build(text, layout, table, declaration, [*layout.notes, *notes])


class _Columns:
    """The columns of a layout, parsed when asked for."""

    def __init__(self, layout: Layout, where: str) -> None:
        self._layout = layout
        self._where = where
        self._known: dict[int, FloatArray] = {}

    def take(self, column: Column) -> FloatArray:
        position = position_of(column, self._layout.names, self._where)
        if position not in self._known:
            self.parse([column])
        return self._known[position]

    def parse(self, columns: list[Column]) -> tuple[Any, Any]:
        """Parse these columns together; a row is readable if all of them are."""
        layout = self._layout
        positions = [position_of(column, layout.names, self._where) for column in columns]
        cells, readable, lines = parse_rows(
            layout.lines, layout.delimiter, len(layout.names), positions, layout.decimal
        )
        self._known |= {position: cells[:, k] for k, position in enumerate(positions)}
        return readable, lines


def _build(
    text: TextFile,
    layout: Layout,
    table: _Columns,
    declaration: Declaration,
    notes: list[str],
) -> Samples:
    optional = [] if declaration.flags is None else [declaration.flags]
    columns: list[Column] = [
        *(c for c in declaration.directions if not (isinstance(c, str) and c.startswith("="))),
        *declaration.values,
        *declaration.sigma,
        *optional,
    ]
    readable, lines = table.parse(list(dict.fromkeys(columns)))
    if not readable.any():
        number, line = layout.lines[0] if layout.lines else (0, "")
        raise CorruptFile(
            f"{text.name}: none of {len(lines)} rows holds numbers in the declared columns; "
            f"expected {len(layout.names)} fields, found for example line {number}: "
            f"{line[:80]!r}. Check the declaration, the delimiter and the decimal mark."
        )
    if not readable.all():
        notes.append(name_lines("rows that could not be read", lines[~readable]))
    names = _names(layout, columns, text.name)
    source = text.source(_NAME, "", notes, _comments(text))
    return samples_from(declaration, table.take, names, readable, lines, source)


def _names(layout: Layout, columns: list[Column], where: str) -> Mapping[Column, str]:
    if not layout.has_names:
        return {}
    return {c: layout.names[position_of(c, layout.names, where)] for c in columns}


def _comments(text: TextFile) -> dict[str, str]:
    """Comment lines of the form "# key: value" or "# key = value", at most 100."""
    found: dict[str, str] = {}
    for _, line in text.lines:
        stripped = line.strip()
        if not stripped.startswith("#") or stripped.startswith(OWN_PREFIX):
            continue
        for mark in (":", "="):
            key, separator, value = stripped.lstrip("# ").partition(mark)
            if separator and key.strip() and len(found) < 100:
                found[key.strip()] = value.strip()
                break
    return found


def _own_header(text: TextFile) -> OwnHeader | None:
    first = text.lines[0][1]
    if not first.startswith(OWN_PREFIX):
        return None
    return OwnHeader.from_json(first.removeprefix(OWN_PREFIX), text.name)


def _read_own(text: TextFile, header: OwnHeader) -> Samples:
    names = header.column_names()
    data = [item for item in text.lines[2:] if item[1].strip()]
    cells, readable, lines = parse_rows(data, ",", len(names))
    notes = [] if readable.all() else [name_lines("rows that could not be read", lines[~readable])]
    source = own_source(header.source, text.source(_NAME, "", notes))
    return samples_from_own(header, np.asarray(cells), readable, lines, source)
