"""From a path to what can be looked at: a table, the files of a fit, or measurements."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from brdfit.files import sha256_of_file
from brdfit.report.fit_files import FitFiles, read_fit
from brdfit.report.fitted import Fitted
from brdfit.report.reading import read_any
from brdfit.samples import Samples, Source
from brdfit.viewer.item import Item
from brdfit.viewer.store import Held
from brdfit.viewer.warned import heard

__all__ = ["open_path"]


def open_path(path: Path, id: str, options: dict[str, Any] | None = None) -> Item | Held:
    """Return an `Item` for a table or the files of a fit, `Held` for measurements.

    Warnings of the readers go along. Raises `BrdfitError` for what cannot be read.
    """
    options = options or {}
    with heard() as warned:
        found = _read(path, options)
    said = warned.messages
    if isinstance(found, Samples):
        return Held(id, path.name, found, path, said)
    judged = found.judged
    source = None if judged is None else _source_beside(path, judged.samples)
    return Item(id, path.name, found, source=source, warnings=said)


def _read(path: Path, options: dict[str, Any]) -> Fitted | Samples:
    files = FitFiles.around(path) if path.is_file() else None
    # Only a table that its own record names is read as such without a look: measurements may
    # lie beside the files of their fit under the same name.
    if files is not None and (path != files.table or _is_named_by(files, path)):
        return _with_source(read_fit(files))
    found = read_any(path, options, "table")
    if isinstance(found, Samples):
        return found
    if files is not None and files.record is not None:
        return _with_source(read_fit(files, **options))
    return Fitted.of_table(found)


def _is_named_by(files: FitFiles, path: Path) -> bool:
    if files.record is None:
        return False
    outputs = json.loads(files.record.read_text(encoding="utf-8")).get("outputs", {})
    return isinstance(outputs, dict) and outputs.get("table") == path.name


def _with_source(fitted: Fitted) -> Fitted:
    """Return a fit whose samples say where they were measured, not which CSV keeps them."""
    try:
        stated = dict(fitted.record["samples"]["source"])
        source = Source(**{**stated, "notes": tuple(stated.get("notes", ()))})
    except (KeyError, TypeError, ValueError):
        return fitted
    if fitted.judged is None:
        return fitted
    samples = replace(fitted.judged.samples, source=source)
    return replace(fitted, judged=replace(fitted.judged, samples=samples))


def _source_beside(path: Path, samples: Samples) -> Path | None:
    """Return the measured file if it still lies beside the table, unchanged."""
    candidate = path.parent / Path(samples.source.name).name
    if not samples.source.sha256 or not candidate.is_file():
        return None
    return candidate if sha256_of_file(candidate) == samples.source.sha256 else None
