"""`Fitted`: a finished fit as it can be told of, whether in memory or from its files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.files import sha256_of_file
from brdfit.grid import MERL_GRID
from brdfit.progress import Progress, silent
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.albedo_curve import AlbedoCurve
from brdfit.report.coverage import coverage_of
from brdfit.report.kept_trust import KeptTrust
from brdfit.report.samples_csv import Judged
from brdfit.report.uncertainty import Uncertainty
from brdfit.table import Table

__all__ = ["SCHEMA", "Fitted", "UsedFile", "agreement", "fit_record"]

SCHEMA = "brdfit.fit/1"
"""What the record of a fit calls itself."""


@dataclass(frozen=True)
class UsedFile:
    """A file that something was made from."""

    role: str
    """What it is: "table", "samples of the fit", ..."""
    name: str
    """Without folders."""
    sha256: str
    """Empty where it did not come from a file."""
    size: int | None = None
    """Bytes; None where it is not known."""

    @classmethod
    def of(cls, role: str, path: Path) -> UsedFile:
        """Return the file at `path` with its hash."""
        return cls(role, path.name, sha256_of_file(path), path.stat().st_size)


@dataclass(frozen=True, eq=False)
class Fitted:
    """A table, and as much as is known of the fit that made it."""

    name: str
    """What to call it: the name of the measurement, or of the table."""
    table: Table
    judged: Judged | None = None
    """The samples and their verdicts; None if only the table is there."""
    record: Mapping[str, Any] = field(default_factory=dict)
    """What `fit_record` returns; empty if it is not there."""
    uncertainty: Uncertainty | None = None
    trust: KeptTrust | None = None
    """Where the result comes from, as the fit itself tells; None if that is not known."""
    files: tuple[UsedFile, ...] = ()
    """The files that this was read from."""
    notes: tuple[str, ...] = ()
    """What is missing or does not fit together, one sentence each."""

    @classmethod
    def of(cls, result: Reconstruction, progress: Progress = silent) -> Fitted:
        """Return the fit `result` with its table on the MERL grid, all channels kept."""
        stated = Uncertainty.of(result, progress)
        trust = KeptTrust.of(result, stated)
        table = result.table(MERL_GRID, progress)
        return cls(
            name=result.samples.source.name,
            table=table,
            judged=Judged.of(result),
            record=fit_record(result, stated, trust, AlbedoCurve.of(table)),
            uncertainty=stated,
            trust=trust,
        )

    @classmethod
    def of_table(cls, table: Table) -> Fitted:
        """Return a table of which nothing else is known."""
        missing = "only the table is known: nothing of measurements, outliers or how it was made"
        return cls(name=table.source.name, table=table, notes=(missing,))


def fit_record(
    result: Reconstruction,
    stated: Uncertainty | None,
    trust: KeptTrust | None = None,
    albedo: AlbedoCurve | None = None,
) -> dict[str, Any]:
    """Return what is kept of a fit, whatever files it leaves, as JSON-able values.

    `albedo` is that of its table with all channels; what is left out is null.
    """
    coverage = coverage_of(result.samples)
    return {
        "schema": SCHEMA,
        **result.record(),
        "coverage": None if coverage is None else coverage.record(),
        "albedo": None if albedo is None else albedo.record(),
        "trust": None if trust is None else trust.record(),
        "uncertainty": None if stated is None else stated.record(),
    }


def agreement(table: Table, judged: Judged) -> float | None:
    """Return the median |difference| between the table and the result that judged the samples.

    Of ln f_r, at the samples; small if table and samples are of one fit. None where they
    cannot be compared, having different channels.
    """
    if table.n_channels != judged.residuals.shape[1]:
        return None
    wi, wo = judged.samples.safe_directions
    value = table.evaluate(wi, wo)
    seen = np.isfinite(judged.residuals) & judged.samples.positive & (value > 0.0)
    if not seen.any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        residuals = np.log(judged.samples.value / value)
    return float(np.median(np.abs(residuals - judged.residuals)[seen]))
