"""Write the report of a fit."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from brdfit.albedo import Evaluable
from brdfit.errors import UsageError
from brdfit.files import atomic_path
from brdfit.progress import Progress, silent
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.compare import compare
from brdfit.report.fit_files import FitFiles, read_fit
from brdfit.report.fitted import Fitted, UsedFile
from brdfit.report.page.contents import contents_of
from brdfit.report.page.render import page_of
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["checked_target", "write_report"]

_SUFFIXES = (".html", ".htm")


def write_report(
    fit: Reconstruction | Table | Fitted | str | os.PathLike[str],
    path: str | os.PathLike[str],
    *,
    reference: Table | Samples | Evaluable | None = None,
    progress: Progress = silent,
) -> None:
    """Write the report of a fit: one HTML file that holds everything it shows.

    Parameters
    ----------
    fit
        A result of `brdfit.fit`, a table, or any of the files that `brdfit fit` left: the
        others are found beside it, and what is missing is said in the report.
    path
        The file to write, `.html`. It appears whole or not at all; equal input gives
        equal bytes.
    reference
        What to compare with: a table, a function of direction, or measurements.
    progress
        Told of long steps (`brdfit.progress`).

    Raises `FormatError` for a file that cannot be read and `UsageError` for a path that
    cannot be written.
    """
    target = checked_target(Path(path))
    fitted = _fitted(fit, progress)
    comparison = None
    name = ""
    if reference is not None:
        comparison = compare(reference, fitted.table, progress=progress)
    if isinstance(reference, Table | Samples):
        name = reference.source.name
        used = UsedFile("reference", name, reference.source.sha256)
        fitted = replace(fitted, files=(*fitted.files, used))
    rendered = reference if isinstance(reference, Table) else None
    contents = contents_of(fitted, comparison, rendered, name, progress)
    page = page_of(contents)
    with atomic_path(target) as aside:
        # a lone surrogate, of a file name that is no text, becomes a question mark
        aside.write_text(page, encoding="utf-8", errors="replace", newline="\n")


def checked_target(path: Path) -> Path:
    """Return `path` if a report can be written there; raise `UsageError` if not."""
    if path.suffix.lower() not in _SUFFIXES:
        raise UsageError(f"{path}: a report is written as .html.")
    if not path.parent.is_dir():
        raise UsageError(
            f"{path}: the folder {str(path.parent)!r} does not exist. Make it first, or name "
            f"another one."
        )
    if path.is_dir():
        raise UsageError(f"{path}: found a folder but expected the name of a file.")
    return path


def _fitted(
    fit: Reconstruction | Table | Fitted | str | os.PathLike[str], progress: Progress
) -> Fitted:
    if isinstance(fit, Fitted):
        return fit
    if isinstance(fit, Reconstruction):
        return Fitted.of(fit, progress)
    if isinstance(fit, Table):
        return Fitted.of_table(fit)
    path = Path(fit)
    files = FitFiles.around(path)
    if files is None:
        raise UsageError(
            f"{path.name}: is neither a table nor a file that a fit left. To report on "
            f"measurements, fit them: write_report(brdfit.fit(brdfit.read_samples(...)), ...)"
        )
    return read_fit(files)
