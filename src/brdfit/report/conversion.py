"""One file made of another, and what that cost."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from brdfit.errors import BrdfitWarning, UsageError
from brdfit.formats import FormatSheet, list_formats, read_samples, write_samples, write_table
from brdfit.formats.sheet import HEAD_BYTES
from brdfit.grid import Grid
from brdfit.report.losses import Loss, losses_of
from brdfit.report.rgb import needs_rgb, rgb_table
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Converted", "convert"]


@dataclass(frozen=True)
class Converted:
    """A conversion that was done."""

    kind: str
    """"samples" or "table"."""
    format: str
    """Name of the format that was written."""
    losses: tuple[Loss, ...]
    """Every aspect, lost or kept; the input's own reading first."""
    notes: tuple[str, ...]
    """What the reader of the input had to say."""

    @property
    def lost(self) -> tuple[str, ...]:
        """Aspects of which something was lost."""
        return tuple(dict.fromkeys(loss.aspect for loss in self.losses if loss.lost))

    def record(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        return {
            "kind": self.kind,
            "format": self.format,
            "lost": list(self.lost),
            "losses": [loss.record() for loss in self.losses],
            "notes": list(self.notes),
        }


def convert(content: Samples | Table, origin: Path, target: Path, sheet: FormatSheet) -> Converted:
    """Write `content`, which was read from `origin`, as `target`, and read that again.

    A table is brought to the channels and the grid that the format wants. Raises `UsageError`
    where the format cannot hold what `content` is.
    """
    if isinstance(content, Samples):
        _check(sheet.write_samples is not None, content, origin, target, sheet)
        write_samples(content, target, format=sheet.name)
        losses = losses_of(content, content, target, sheet)
        return Converted("samples", sheet.name, losses, content.source.notes)
    _check(sheet.write_table is not None, content, origin, target, sheet)
    written, prepared = _fitting(content, sheet)
    write_table(written, target, format=sheet.name)
    losses = (*_reading(content, origin), *prepared, *losses_of(content, written, target, sheet))
    return Converted("table", sheet.name, losses, content.source.notes)


def _check(
    able: bool, content: Samples | Table, origin: Path, target: Path, sheet: FormatSheet
) -> None:
    if able:
        return
    if isinstance(content, Samples):
        raise UsageError(
            f"{target.name}: {sheet.title} holds a complete table, but {origin.name} holds "
            f"{len(content)} samples. To make a table of them: brdfit fit {origin} -o {target}"
        )
    raise UsageError(
        f"{target.name}: {sheet.title} holds samples, but {origin.name} holds a table. To "
        f"sample it at directions of your own: brdfit evaluate {origin} --at DIRECTIONS.csv"
    )


def _fitting(table: Table, sheet: FormatSheet) -> tuple[Table, tuple[Loss, ...]]:
    """Return the table that the format can hold, and what making it cost."""
    losses: list[Loss] = []
    written = table
    if needs_rgb(table, sheet):
        written, conversion = rgb_table(table)
        if conversion.kind != "none":
            lost = conversion.kind == "spectral" or table.n_channels > 1
            losses.append(Loss("colour", lost, str(conversion), conversion.record()))
    if sheet.grid is not None and written.grid != sheet.grid:
        before = written.grid.shape
        written = _on_grid(written, sheet.grid)
        was, now = (" x ".join(map(str, shape)) for shape in (before, sheet.grid.shape))
        losses.append(
            Loss(
                "grid",
                True,
                f"interpolated from {was} cells to {now}, the only grid of this format",
                {"before": list(before), "after": list(sheet.grid.shape)},
            )
        )
    return written, tuple(losses)


def _on_grid(table: Table, grid: Grid) -> Table:
    import numpy as np

    values = np.zeros((grid.size, table.n_channels))
    values[grid.cells] = table.evaluate(*grid.directions(grid.cells))
    return Table(
        values.reshape(*grid.shape, -1),
        grid=grid,
        wavelengths=table.wavelengths,
        channels=table.channels,
        source=table.source,
    )


def _reading(table: Table, origin: Path) -> tuple[Loss, ...]:
    """Return what making a table of the input's own values was, where it holds others."""
    sheet = next((sheet for sheet in list_formats() if sheet.name == table.source.format), None)
    if sheet is None or not sheet.averages or sheet.read_samples is None:
        return ()
    with origin.open("rb") as stream:
        if not sheet.sniff(origin, stream.read(HEAD_BYTES)):
            return ()  # a table of ours that came from such a file once
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        values = len(read_samples(origin, format=sheet.name))
    cells = int(table.mask.sum())
    return (
        Loss(
            "reading",
            True,
            f"{origin.name} holds {values:,} values of its own; the table of {cells:,} cells "
            f"interpolates between them",
            {"values": values, "cells": cells},
        ),
    )
