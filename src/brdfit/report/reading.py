"""Read a file without knowing whether it holds samples or a table."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from brdfit.errors import BrdfitError, UsageError

if TYPE_CHECKING:
    from brdfit.samples import Samples
    from brdfit.table import Table

__all__ = ["Kind", "read_any", "read_table_of"]

Kind = Literal["samples", "table"]


def read_any(path: Path, options: dict[str, Any], first: Kind) -> Samples | Table:
    """Return what `path` holds; `first` wins where it can be read as both.

    STORE.zarr#NAME is the table of an item of a batch. If neither can be read the error of the
    kind that its format has is raised.
    """
    _refuse_record(path)
    of_batch = _item_of_batch(path)
    if of_batch is not None:
        return of_batch
    from brdfit.formats import read_samples, read_table

    readers: dict[Kind, Callable[..., Samples | Table]] = {
        "samples": read_samples,
        "table": read_table,
    }
    second: Kind = "table" if first == "samples" else "samples"
    order = [kind for kind in (first, second) if _offers(path, options.get("format"), kind)]
    error: BrdfitError | None = None
    for kind in order or [first]:
        try:
            return readers[kind](path, **options)
        except BrdfitError as problem:
            error = error or problem
    assert error is not None
    raise error


def read_table_of(path: Path, **options: Any) -> Table:
    """Return the table of a file, or of an item of a batch (STORE.zarr#NAME)."""
    from brdfit.formats import read_table

    _refuse_record(path)
    found = _item_of_batch(path)
    return read_table(path, **options) if found is None else found


def _refuse_record(path: Path) -> None:
    """Say which file is meant where the record of a fit is named for its table."""
    if path.suffix.lower() != ".json":
        return
    from brdfit.report.fit_files import kept_record, outputs_of

    record = kept_record(path)
    if record is not None:
        table = outputs_of(record).get("table", "its table")
        raise UsageError(f"{path}: is the record of a fit; name {table} instead.")


def _item_of_batch(path: Path) -> Table | None:
    store, mark, item = str(path).partition(".zarr#")
    folder = Path(f"{store}.zarr")
    if not mark and path.suffix == ".zarr" and path.is_dir():
        raise UsageError(
            f"{path}: holds many items; name one of them: {path}#NAME, or {path}#0 for the first."
        )
    if not mark or not folder.is_dir():
        return None
    from brdfit.batch import open_batch

    return open_batch(folder)[item].table()


def _offers(path: Path, format: str | None, kind: Kind) -> bool:
    """Whether the format of `path` can hold this kind; True where the format is not known."""
    from brdfit.formats import list_formats
    from brdfit.formats.sheet import HEAD_BYTES

    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError:
        # The reader says what is wrong with the path.
        return True
    for sheet in list_formats():
        if sheet.name == format or (format is None and sheet.sniff(path, head)):
            return getattr(sheet, f"read_{kind}") is not None
    return True
