"""Read brdfit's `.npz`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy.typing as npt

from brdfit.errors import CorruptFile, UsageError
from brdfit.formats.npz.archive import Archive, open_archive
from brdfit.formats.npz.layout import HEADER, KINDS, VERSION
from brdfit.grid import Grid
from brdfit.samples import Samples, Source
from brdfit.table import Table

__all__ = ["read_samples", "read_table"]


def read_samples(path: Path) -> Samples:
    """Return the samples of a file, flags and source included, as they were written."""
    header, arrays = _read(path, "samples")
    try:
        return Samples(**arrays, channels=header.channels, source=header.source)
    except UsageError as error:
        raise CorruptFile(f"{path.name}: the arrays do not fit together: {error}") from error


def read_table(path: Path) -> Table:
    """Return the table of a file, mask and source included, as it was written."""
    header, arrays = _read(path, "table")
    try:
        grid = Grid(*arrays["values"].shape[:3])
        if arrays["valid"].shape != grid.shape:
            raise UsageError(
                f"values are on a grid of {grid.shape} but valid has the shape "
                f"{arrays['valid'].shape}."
            )
        return Table(
            values=arrays["values"],
            grid=grid,
            valid=arrays["valid"],
            wavelengths=arrays.get("wavelengths"),
            channels=header.channels,
            source=header.source,
        )
    except UsageError as error:
        raise CorruptFile(f"{path.name}: the arrays do not fit together: {error}") from error


@dataclass(frozen=True)
class _Header:
    kind: str
    channels: tuple[str, ...]
    source: Source


def _read(path: Path, kind: str) -> tuple[_Header, dict[str, npt.NDArray[Any]]]:
    with open_archive(path) as archive:
        header = _header(archive)
        if header.kind != kind:
            raise UsageError(
                f"{path.name}: holds {header.kind}, not {kind}. Read it with "
                f"brdfit.read_{header.kind}."
            )
        return header, _arrays(archive, kind)


def _arrays(archive: Archive, kind: str) -> dict[str, npt.NDArray[Any]]:
    expected = KINDS[kind]
    unknown = sorted(set(archive.members) - set(expected) - {HEADER})
    if unknown:
        raise CorruptFile(
            f"{archive.name}: the array {unknown[0]!r} does not belong to {kind}; expected are "
            f"{', '.join(expected)}."
        )
    arrays = {}
    for name, member in expected.items():
        if name not in archive.members:
            if member.optional:
                continue
            raise CorruptFile(f"{archive.name}: the array {name!r} of the {kind} is missing.")
        array = archive.array(name)
        if array.ndim != member.dimensions or array.dtype.kind not in member.kinds:
            raise CorruptFile(
                f"{archive.name}: the array {name!r} has the shape {array.shape} and the type "
                f"{array.dtype} but {member.dimensions} dimensions of kind {member.kinds!r} were "
                f"expected."
            )
        arrays[name] = array
    return arrays


def _header(archive: Archive) -> _Header:
    if HEADER not in archive.members:
        found = ", ".join(sorted(archive.members)[:8]) or "nothing"
        raise CorruptFile(
            f"{archive.name}: is an .npz but not one of brdfit's: the array {HEADER!r} is missing "
            f"(found: {found}). Load it with numpy, build brdfit.Samples(wi=..., wo=..., "
            f"value=...) and write that."
        )
    content = _json(archive)
    version, kind = content.get("version"), content.get("kind")
    if version != VERSION:
        raise CorruptFile(
            f"{archive.name}: has version {version!r} of the layout but this brdfit reads "
            f"{VERSION}. Update brdfit, or write the file again."
        )
    if kind not in KINDS:
        raise CorruptFile(
            f"{archive.name}: holds {kind!r} but one of {', '.join(KINDS)} was expected."
        )
    channels: Any = content.get("channels")
    if not _are_texts(channels):
        raise CorruptFile(f"{archive.name}: 'channels' is {channels!r} but names were expected.")
    return _Header(kind, tuple(channels), _source(content.get("source"), archive.name))


def _json(archive: Archive) -> dict[str, Any]:
    raw = archive.array(HEADER).tobytes()
    try:
        content = json.loads(raw)
    except (ValueError, RecursionError) as error:
        raise CorruptFile(f"{archive.name}: the header is not JSON ({error}).") from error
    if not isinstance(content, dict):
        raise CorruptFile(f"{archive.name}: the header is {content!r} but an object was expected.")
    return content


def _source(content: Any, name: str) -> Source:
    texts = ("name", "format", "sha256", "convention")
    good = (
        isinstance(content, dict)
        and all(isinstance(content.get(key), str) for key in texts)
        and _are_texts(content.get("notes"))
        and isinstance(content.get("metadata"), dict)
        and _are_texts(list(content["metadata"].values()))
    )
    if not good:
        raise CorruptFile(
            f"{name}: 'source' in the header is {content!r:.200} but the texts "
            f"{', '.join(texts)}, notes and metadata were expected."
        )
    return Source(
        **{key: content[key] for key in texts},
        notes=tuple(content["notes"]),
        metadata=dict(content["metadata"]),
    )


def _are_texts(values: Any) -> bool:
    return isinstance(values, list) and all(isinstance(value, str) for value in values)
