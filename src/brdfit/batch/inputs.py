"""From a path or pattern to an input."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from brdfit.batch.columns import ParquetTable, ZarrTable
from brdfit.batch.folder import FolderInput
from brdfit.batch.long_table import TableInput
from brdfit.batch.source import BatchInput
from brdfit.errors import UsageError

__all__ = ["open_input"]


def open_input(
    path: str | Path,
    options: Mapping[str, Any] | None = None,
    item: str | None = None,
    position: Sequence[str] = (),
) -> BatchInput:
    """Return the items at `path`: a folder, a glob pattern, or a long table.

    A `.parquet` file or a Zarr group is a long table: columns of the item, the directions and
    the values, optionally sigma and pixel position. `options` are those of `read_samples`.
    Raises `UsageError` where there is nothing, or the columns are not clear.
    """
    path, options = str(path), options or {}
    place = Path(path)
    if place.is_file() and place.suffix.lower() in (".parquet", ".pq"):
        return TableInput.of(ParquetTable(path), options, item, position)
    if place.is_dir() and _is_zarr(place):
        return TableInput.of(ZarrTable(path), options, item, position)
    if item is not None or position:
        raise UsageError(
            f"{path}: --item and --position name columns of one long table (.parquet, .zarr)."
        )
    return FolderInput.of(path, options)


def _is_zarr(folder: Path) -> bool:
    return any((folder / name).is_file() for name in ("zarr.json", ".zgroup"))
