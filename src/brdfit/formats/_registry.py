"""Which formats there are, which one a file is of, and the calls into its sheet.

The formats are an explicit list of folders, imported when the first file is met. Content
decides, the most particular format first; the suffix only helps the error message. A `sniff` that
crashes counts as "no" and is named in the error, never fatal.
"""

from __future__ import annotations

import difflib
import os
import struct
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import numpy as np

from brdfit.errors import (
    BrdfitError,
    CorruptFile,
    DataQualityWarning,
    FormatError,
    NotThisFormat,
    UnknownFormat,
    UsageError,
)
from brdfit.formats.convention_check import warn_about_conventions
from brdfit.formats.sheet import HEAD_BYTES, FormatSheet
from brdfit.samples import Flag, Samples
from brdfit.table import Table

__all__ = [
    "format_to_write",
    "list_formats",
    "read_samples",
    "read_table",
    "rivals",
    "write_samples",
    "write_table",
]

# Order of the questions: formats with a magic number first, the most general text last.
_FOLDERS = (
    "npz",
    "rgl",
    "exr",
    "nbrdf",
    "rt300s",
    "zemax",
    "lighttools",
    "tensortree",
    "klems",
    "merl",
    "utia",
    "astm",
    "nist",
    "curet",
    "alta",
    "parquet",
    "delimited",
)

# What a parser meets in a damaged file; anything else is a defect and shows its traceback.
_PARSE_ERRORS = (ValueError, LookupError, ArithmeticError, EOFError, struct.error)

_FEW = 10

Path_ = str | os.PathLike[str]


@cache
def list_formats() -> tuple[FormatSheet, ...]:
    """Return the data sheets of all formats, in the order in which content is sniffed."""
    return tuple(import_module(f"brdfit.formats.{folder}").SHEET for folder in _FOLDERS)


def read_samples(path: Path_, *, format: str | None = None, **options: Any) -> Samples:
    """Read measurements from a file; the content tells the format.

    Parameters: `path`; `format`, the name of a sheet (see `list_formats`) to skip the
    sniffing; `options`, those of the format, such as the declared columns of delimited
    text (see `brdfit.formats.declaration.Declaration`).

    Every row of the file becomes a sample: what cannot be used is flagged. Gives a
    `DataQualityWarning` that counts the unusable rows, and a `ConventionWarning` where the
    data contradict the convention they were read with.

    Raises `FormatError` (`UnknownFormat`, `CorruptFile`) for the file and `UsageError` for
    the options.
    """
    samples: Samples = _read(Path(path), format, options, _SAMPLES)
    _warn_about_quality(samples)
    warn_about_conventions(samples)
    return samples


def read_table(path: Path_, *, format: str | None = None, **options: Any) -> Table:
    """Read a dense table from a file; the content tells the format.

    Parameters and errors as for `read_samples`.
    """
    table: Table = _read(Path(path), format, options, _TABLE)
    return table


def write_table(table: Table, path: Path_, *, format: str | None = None) -> None:
    """Write a dense table; the suffix tells the format unless `format` names it.

    The file appears whole or not at all.
    """
    sheet = format_to_write(path, format=format, kind="table")
    assert sheet.write_table is not None
    _write(sheet.write_table, table, Path(path))


def write_samples(samples: Samples, path: Path_, *, format: str | None = None) -> None:
    """Write samples with their flags; the suffix tells the format unless `format` names it.

    The file appears whole or not at all.
    """
    sheet = format_to_write(path, format=format, kind="samples")
    assert sheet.write_samples is not None
    _write(sheet.write_samples, samples, Path(path))


@dataclass(frozen=True)
class _Kind:
    """Samples or a table: which entries of a sheet, and which words in a message."""

    noun: str
    other: str
    advice: str
    """What to do with a file that only holds the other."""

    def reader(self, sheet: FormatSheet) -> Callable[..., Any] | None:
        return getattr(sheet, f"read_{self.noun}")  # type: ignore[no-any-return]

    def writer(self, sheet: FormatSheet) -> Callable[..., Any] | None:
        return getattr(sheet, f"write_{self.noun}")  # type: ignore[no-any-return]


_SAMPLES = _Kind("samples", "table", "Read it with brdfit.read_table.")
_TABLE = _Kind(
    "table",
    "samples",
    "Fit it first, with `brdfit fit`; in Python, read it with brdfit.read_samples.",
)


def _read(path: Path, format: str | None, options: dict[str, Any], kind: _Kind) -> Any:
    head = _head_of(path)
    if format is not None:
        return _call(_sheet_named(format), path, options, kind)
    declined: list[str] = []
    for sheet in list_formats():
        try:
            recognised = sheet.sniff(path, head)
        except Exception as error:  # a sniff of any format must not stop the others
            declined.append(f"{sheet.name} (failed while looking: {error!r})")
            continue
        if not recognised:
            declined.append(sheet.name)
            continue
        try:
            return _call(sheet, path, options, kind)
        except NotThisFormat as error:
            declined.append(f"{sheet.name} ({error})")
    raise UnknownFormat(_unknown(path, declined))


def _call(sheet: FormatSheet, path: Path, options: dict[str, Any], kind: _Kind) -> Any:
    reader = kind.reader(sheet)
    if reader is None:
        raise UsageError(
            f"{path.name}: found {sheet.title}, which holds {kind.other} but no {kind.noun}. "
            f"{kind.advice}"
        )
    _check_options(sheet, options)
    try:
        # infinite and missing numbers of a file end as flags, not as warnings of NumPy
        with np.errstate(all="ignore"):
            return reader(path, **options)
    except BrdfitError:
        raise
    except OSError as error:
        raise FormatError(f"{path.name}: cannot be read: {error.strerror or error}.") from error
    except _PARSE_ERRORS as error:
        raise CorruptFile(
            f"{path.name}: looked like {sheet.title}, but reading it failed "
            f"({type(error).__name__}: {error}). The file is damaged or of a variant that is "
            f"not known; name another reader with format=..., or convert it to CSV."
        ) from error


def _check_options(sheet: FormatSheet, options: Iterable[str]) -> None:
    for name in options:
        if name not in sheet.options:
            allowed = ", ".join(sheet.options) or "none"
            raise UsageError(
                f"{name!r} is not an option of the format {sheet.name!r}"
                f"{did_you_mean(name, sheet.options)} Allowed: {allowed}."
            )


def _head_of(path: Path) -> bytes:
    if path.is_dir():
        raise FormatError(f"{path.name}: is a folder, but a file was expected.")
    try:
        with open(path, "rb") as stream:
            head = stream.read(HEAD_BYTES)
    except FileNotFoundError as error:
        raise FormatError(f"{path}: there is no such file. Check the name.") from error
    except OSError as error:
        raise FormatError(f"{path.name}: cannot be read: {error.strerror or error}.") from error
    if not head:
        raise FormatError(
            f"{path.name}: is empty (0 bytes), but measurements or a table were expected. "
            f"Copy or export the file again."
        )
    return head


def _unknown(path: Path, declined: list[str]) -> str:
    hints = [sheet.title for sheet in list_formats() if path.suffix.lower() in sheet.extensions]
    by_name = f" By its suffix it should be {' or '.join(hints)}." if hints else ""
    return (
        f"{path.name}: no reader recognises the content; tried {', '.join(declined)}.{by_name} "
        f"If it is text or Parquet with one measurement in each row, declare its columns in "
        f"{path.name}.toml beside it or by options (format='delimited', directions=..., "
        f"values=..., angles=...); see docs/formats.md."
    )


def _sheet_named(name: str) -> FormatSheet:
    sheets = {sheet.name: sheet for sheet in list_formats()}
    if name not in sheets:
        raise UsageError(
            f"there is no format {name!r}{did_you_mean(name, sheets)} Formats: {', '.join(sheets)}."
        )
    return sheets[name]


def format_to_write(
    path: Path_, *, format: str | None = None, kind: Literal["samples", "table"] | None = None
) -> FormatSheet:
    """Return the sheet that a file is written by: the one named, else the first of its suffix.

    `kind`: what is to be written; None for either. Raises `UsageError` that names what can be
    written.
    """
    kinds = [_SAMPLES, _TABLE] if kind is None else [_SAMPLES if kind == "samples" else _TABLE]
    able = [s for s in list_formats() if any(one.writer(s) is not None for one in kinds)]
    known = ", ".join(f"{sheet.name} ({' '.join(sheet.extensions)})" for sheet in able)
    noun = {None: "a file", "table": "a table"}.get(kind, "samples")
    if format is not None:
        sheet = _sheet_named(format)
        if sheet in able:
            return sheet
        raise UsageError(f"the format {format!r} cannot be written as {noun}. These can: {known}.")
    name, suffix = Path(path).name, Path(path).suffix
    for sheet in able:
        if suffix.lower() in sheet.extensions:
            return sheet
    if Path(path).is_dir():
        raise UsageError(f"{path}: is a folder, but the name of a file to write was expected.")
    raise UsageError(
        f"{name}: the suffix {suffix!r} does not say how to write {noun}. Use one of: {known}; or "
        f"name the format (format=..., on the command line --to)."
    )


def rivals(sheet: FormatSheet, path: Path_) -> tuple[str, ...]:
    """Return the names of other formats that are written under the suffix of `path`."""
    suffix = Path(path).suffix.lower()
    writes = (s for s in list_formats() if s.write_table is not None or s.write_samples is not None)
    return tuple(s.name for s in writes if s is not sheet and suffix in s.extensions)


def _write(writer: Callable[[Any, Path], Any], what: Samples | Table, path: Path) -> None:
    if path.is_dir():
        raise FormatError(f"{path.name}: is a folder, but the name of a file was expected.")
    if not path.parent.is_dir():
        raise FormatError(f"{path.parent}: there is no such folder to write {path.name} into.")
    try:
        writer(what, path)
    except OSError as error:
        raise FormatError(f"{path.name}: cannot be written: {error.strerror or error}.") from error


def _warn_about_quality(samples: Samples) -> None:
    name, n = samples.source.name, len(samples)
    # rejected rows are no news: the file or the user said so
    unusable = ~samples.usable.any(axis=1) & ((samples.bits & int(Flag.REJECTED)) == 0)
    if unusable.any():
        lost = samples.subset(unusable).flag_counts()
        for unrelated in (Flag.CENSORED, Flag.DUPLICATE, Flag.PARTLY_MISSING):
            lost.pop(str(unrelated.name).lower(), None)
        counts = ", ".join(f"{count} {flag}" for flag, count in lost.items())
        where = ""
        if samples.rows is not None:
            first = samples.rows[unusable][:5]
            more = ", ..." if unusable.sum() > len(first) else ""
            where = f", rows {', '.join(str(row) for row in first)}{more}"
        message = (
            f"{name}: {int(unusable.sum())} of {n} samples cannot be used ({counts}{where}); "
            f"they are kept and flagged."
        )
        warnings.warn(message, DataQualityWarning, stacklevel=3)
    usable = int(np.count_nonzero(samples.usable.any(axis=1)))
    if usable < _FEW:
        message = (
            f"{name}: only {usable} usable samples. A reconstruction will "
            f"lean almost wholly on its population; measure more directions."
        )
        warnings.warn(message, DataQualityWarning, stacklevel=3)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ". Did you mean ...?" for the closest known name, or a full stop."""
    close = difflib.get_close_matches(name, list(known), n=1)
    return f". Did you mean {close[0]!r}?" if close else "."
