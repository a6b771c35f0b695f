"""The files of a fit found again: any one of them leads to the others.

`brdfit fit` leaves a table, a record and the samples beside each other (`fit_outputs`).
Files with the table's own stem come first, then those that the record names: a set that was
renamed together stays together.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from brdfit.errors import CorruptFile, UsageError
from brdfit.formats import read_table
from brdfit.report.fitted import SCHEMA, Fitted, UsedFile, agreement
from brdfit.report.kept_trust import KeptTrust
from brdfit.report.samples_csv import Judged, read_samples_csv
from brdfit.report.uncertainty import Uncertainty
from brdfit.table import Table

__all__ = ["FitFiles", "kept_record", "outputs_of", "read_fit"]

# Interpolation in the table moves ln f by less than this at most samples.
_ALIKE = 0.05


@dataclass(frozen=True)
class FitFiles:
    """Where the files of a fit are; None for one that is not there."""

    table: Path
    record: Path | None
    samples: Path | None

    @classmethod
    def around(cls, path: Path) -> FitFiles | None:
        """Return the files that `path`, one of them, belongs to; None if it is of no fit.

        A table always belongs to itself, with or without others; it is recognised by being
        neither a record nor the samples of a fit.
        """
        if path.suffix.lower() not in (".json", ".csv"):
            record = _record_beside(path)
            return cls(path, record, _samples_beside(path, record))
        record = path if path.suffix.lower() == ".json" else _record_beside(path)
        if record is None or _content(record) is None:
            return None
        outputs = _outputs(record)
        if path != record and not (outputs.get("samples") == path.name and _is_of_a_fit(path)):
            return None
        table = record.parent / outputs.get("table", "")
        if not table.is_file():
            raise UsageError(
                f"{path.name}: belongs to a fit whose table {outputs.get('table')!r} is not beside "
                f"it. Bring the table back, or fit again."
            )
        return cls(table, record, _samples_beside(table, record))


def read_fit(files: FitFiles, table: Table | None = None) -> Fitted:
    """Read the files of a fit; `table` is that of `files.table`, where it was read already.

    What is missing, or does not fit together, is said in `notes`. Raises `FormatError` for a
    file that is damaged.
    """
    table = read_table(files.table) if table is None else table
    record = _content(files.record) if files.record is not None else None
    judged = None if files.samples is None else read_samples_csv(files.samples)
    uncertainty, trust = _doubts(record or {}, judged, _shown(files.record))
    notes = [*_missing(files)]
    if record is not None:
        notes += _renamed(files, record)
    if judged is not None:
        notes += _disagreement(Fitted("", table, judged))
    return Fitted(
        name=_name(files, record),
        table=table,
        judged=judged,
        record=record or {},
        uncertainty=uncertainty,
        trust=trust,
        files=tuple(_used(files)),
        notes=tuple(notes),
    )


def _doubts(
    record: dict[str, Any], judged: Judged | None, where: str
) -> tuple[Uncertainty | None, KeptTrust | None]:
    """Return what the record keeps of them; None for what it, or an older one, does not."""
    stated, classes = record.get("uncertainty"), record.get("trust")
    uncertainty = Uncertainty.from_record(stated, where) if stated else None
    if not classes or judged is None:
        return uncertainty, None
    return uncertainty, KeptTrust.from_record(classes, judged, uncertainty, where)


def kept_record(path: Path) -> dict[str, Any] | None:
    """Return the record of a fit that the file at `path` is; None if it is something else."""
    if path.suffix.lower() != ".json" or not path.is_file():
        return None
    # damaged JSON is a matter for the readers of measurements, which may be told what it is
    with suppress(CorruptFile):
        return _content(path)
    return None


def _record_beside(path: Path) -> Path | None:
    stem = path.with_suffix("")
    if stem.suffix == ".fit":
        stem = stem.with_suffix("")
    for suffix in (".fit.json", ".json"):
        candidate = stem.parent / (stem.name + suffix)
        # a damaged or strange file of that name is no record: what is missing will be said
        with suppress(CorruptFile):
            if candidate.is_file() and _content(candidate) is not None:
                return candidate
    return None


def _samples_beside(table: Path, record: Path | None) -> Path | None:
    names = [f"{table.stem}.fit.csv", f"{table.stem}.csv"]
    if record is not None:
        names.append(_outputs(record).get("samples", ""))
    for name in filter(None, names):
        candidate = table.parent / name
        if candidate.is_file() and _is_of_a_fit(candidate):
            return candidate
    return None


def _is_of_a_fit(path: Path) -> bool:
    """Whether a CSV is what a fit wrote, and not measurements of the same name."""
    with path.open("rb") as stream:
        return stream.readline(4096).lstrip(b'"').startswith(b"brdfit_row")


def _content(path: Path) -> dict[str, Any] | None:
    """Return the record of a fit; None for JSON of another kind."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise CorruptFile(
            f"{path.name}: is not JSON ({error}) but the record of a fit was expected. Fit again, "
            f"or move it away."
        ) from error
    if isinstance(content, dict) and content.get("schema") == SCHEMA:
        return content
    return None


def outputs_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Return what the files of a fit are called, by role; none where its record does not say."""
    outputs = record.get("outputs")
    if not isinstance(outputs, dict):
        return {}
    # names, never paths: a record must not lead out of its folder
    return {str(role): Path(str(name)).name for role, name in outputs.items()}


def _outputs(record: Path) -> dict[str, str]:
    return outputs_of(_content(record) or {})


def _missing(files: FitFiles) -> list[str]:
    table, stem = files.table.name, files.table.stem
    notes = []
    if files.record is None:
        notes.append(
            f"no readable record of a fit ({stem}.json) lies beside {table}: how it was made is "
            f"not known"
        )
    if files.samples is None:
        notes.append(
            f"no samples of a fit ({stem}.csv) lie beside {table}: neither measurements nor "
            f"outliers can be shown"
        )
    return notes


def _renamed(files: FitFiles, record: dict[str, Any]) -> list[str]:
    assert files.record is not None
    named = _outputs(files.record).get("table", "")
    if named == files.table.name:
        return []
    return [
        f"{files.record.name} is the record of a table called {named!r}, not "
        f"{files.table.name!r}: it was renamed, or belongs to another fit"
    ]


def _disagreement(fitted: Fitted) -> list[str]:
    assert fitted.judged is not None
    off = agreement(fitted.table, fitted.judged)
    if off is None or off < _ALIKE:
        return []
    return [
        f"the table differs from the result that the samples were judged by (median "
        f"|delta ln f| {off:.2g}): the files are not of one fit, or the table was changed since"
    ]


def _name(files: FitFiles, record: dict[str, Any] | None) -> str:
    try:
        name = (record or {})["samples"]["source"]["name"]
    except (KeyError, TypeError):
        return files.table.name
    return str(name)


def _shown(path: Path | None) -> str:
    return "" if path is None else path.name


def _used(files: FitFiles) -> list[UsedFile]:
    roles = {
        "table": files.table,
        "record of the fit": files.record,
        "samples of the fit": files.samples,
    }
    return [UsedFile.of(role, path) for role, path in roles.items() if path is not None]
