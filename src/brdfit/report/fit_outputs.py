"""What a fit leaves on disk: the table, and beside it a picture, a record and the samples.

    out.binary     the complete BRDF
    out.png        spheres, slices with the measurements
    out.json       everything a script needs
    out.csv        the samples with their weight and residual

The four appear together or not at all.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from brdfit.errors import UsageError
from brdfit.grid import MERL_GRID, Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct.energy import LimitedAlbedo
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.albedo_curve import AlbedoCurve
from brdfit.report.coverage import coverage_of
from brdfit.report.file_set import write_set
from brdfit.report.fit_figure import draw_fit
from brdfit.report.fitted import fit_record
from brdfit.report.kept_trust import KeptTrust
from brdfit.report.rgb import Conversion, needs_rgb, rgb_table
from brdfit.report.samples_csv import write_samples_csv
from brdfit.report.uncertainty import Uncertainty
from brdfit.table import Table
from brdfit.tone import colour_library

__all__ = ["FitOutputs", "FitPaths", "write_fit"]


@dataclass(frozen=True)
class FitPaths:
    """Where the four files go."""

    table: Path
    picture: Path
    record: Path
    samples: Path
    format: str
    """Name of the table's format."""

    @classmethod
    def beside(
        cls, table: Path, inputs: Collection[Path] = (), format: str | None = None
    ) -> FitPaths:
        """Return the paths for a table, none of which is one of `inputs`.

        `format` names the table's format where its suffix does not.

        A file beside the table that would replace an input gets `.fit` before its suffix.
        Raises `UsageError` if the table itself would, if its folder is missing, or if no
        format that tables can be written in is named.
        """
        from brdfit.formats import format_to_write

        sheet = format_to_write(table, format=format, kind="table")
        if not table.parent.is_dir():
            raise UsageError(
                f"{table}: the folder {str(table.parent)!r} does not exist. Make it first, or name "
                f"another one."
            )
        taken = {path.resolve() for path in inputs}
        if table.resolve() in taken:
            raise UsageError(f"{table}: is the input; the output must be another file.")

        def free(suffix: str) -> Path:
            path = table.with_suffix(suffix)
            return table.with_suffix(f".fit{suffix}") if path.resolve() in taken else path

        return cls(table, free(".png"), free(".json"), free(".csv"), sheet.name)

    def all(self) -> tuple[Path, ...]:
        """Return the four, the table first."""
        return (self.table, self.picture, self.record, self.samples)


@dataclass(frozen=True)
class FitOutputs:
    """What was written, and what it cost."""

    paths: FitPaths
    table: Table
    """The table as it is in the file."""
    conversion: Conversion
    """How the table in the file came to its channels; "none" where they were kept."""
    record: dict[str, Any]
    """The content of the JSON file."""
    albedo: AlbedoCurve
    """What the table, with all channels, reflects."""
    limited: LimitedAlbedo | None
    """What became of the limit; None where it was not asked for."""


def write_fit(
    result: Reconstruction,
    paths: FitPaths,
    *,
    context: Mapping[str, Any] | None = None,
    grid: Grid = MERL_GRID,
    limit_albedo: bool = False,
    progress: Progress = silent,
) -> FitOutputs:
    """Write the four files of a fit.

    `context` (the command's options, warnings so far, ...) goes into the record as it is.
    With `limit_albedo` the table is `Reconstruction.limited_table`; weights and residuals in
    the samples stay those of the fit.
    """
    from brdfit.formats import format_to_write, write_table

    _import_ahead(spectral=result.samples.wavelengths is not None)
    limited = result.limited_table(grid, progress) if limit_albedo else None
    full = result.table(grid, progress) if limited is None else limited.table
    rgb, conversion = rgb_table(full)
    written, cost = full, Conversion("none", full.n_channels)
    if needs_rgb(full, format_to_write(paths.table, format=paths.format)):
        written, cost = rgb, conversion
    coverage = coverage_of(result.samples)
    stated, albedo = Uncertainty.of(result, progress), AlbedoCurve.of(full)
    made = fit_record(result, stated, KeptTrust.of(result, stated), albedo)
    made["albedo"]["limited"] = None if limited is None else limited.record()
    record = _record(made, paths, cost, context or {})
    shown = result if limited is None else limited.table
    writers: dict[Path, Callable[[Path], object]] = {
        paths.table: lambda aside: write_table(written, aside, format=paths.format),
        paths.picture: lambda aside: draw_fit(result, shown, rgb, coverage, aside, progress),
        paths.record: lambda aside: aside.write_text(_json(record), encoding="utf-8"),
        paths.samples: lambda aside: write_samples_csv(result, aside),
    }
    write_set(writers)
    return FitOutputs(paths, written, cost, record, albedo, limited)


def _import_ahead(spectral: bool) -> None:
    """Import on another thread what is needed next, while the dense result is computed.

    Array arithmetic leaves a second processor to it, and colour alone takes a second or
    two. Where it fails, the import that follows says why.
    """

    def load() -> None:
        with suppress(Exception):
            import_module("matplotlib.backends.backend_agg")
            if spectral:
                colour_library()

    threading.Thread(target=load, daemon=True).start()


def _json(record: dict[str, Any]) -> str:
    """Return strict JSON: what is not finite becomes null, which any reader understands."""

    def plain(value: Any) -> Any:
        if isinstance(value, float) and not math.isfinite(value):
            return None
        if isinstance(value, Mapping):
            return {str(key): plain(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [plain(item) for item in value]
        return value

    return json.dumps(plain(record), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def _record(
    made: dict[str, Any], paths: FitPaths, conversion: Conversion, context: Mapping[str, Any]
) -> dict[str, Any]:
    names = ("table", "picture", "record", "samples")
    long_lines = {name: made.pop(name) for name in ("albedo", "trust", "uncertainty")}
    return {
        **made,
        "channels_written": conversion.record(),
        "outputs": {name: path.name for name, path in zip(names, paths.all(), strict=True)},
        **context,
        **long_lines,
    }
