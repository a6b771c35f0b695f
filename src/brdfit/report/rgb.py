"""What a file or a picture of three channels shows of a table with any number of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.formats.sheet import FormatSheet
from brdfit.table import Table

__all__ = ["Conversion", "needs_rgb", "rgb_table"]

# Cells converted at a time: 31 bands of a million cells need not be doubled at once.
_BLOCK = 1 << 17


@dataclass(frozen=True)
class Conversion:
    """How a table came to have three channels, and what that cost."""

    kind: str
    """"none" (kept), "order" (R, G, B put in order), "grey" or "spectral"."""
    from_channels: int
    """Channels before."""
    clipped_cells: int = 0
    """Cells with a negative R, G or B (a colour outside sRGB), which was set to 0."""
    clipped_share: float = 0.0
    """The same as a share of the valid cells."""
    most_negative: float = 0.0
    """The most negative value before it was set to 0, over the largest of its cell."""

    def record(self) -> dict[str, Any]:
        """Return the figures as JSON-able values."""
        return asdict(self)

    def __str__(self) -> str:
        """Return one sentence for a person; empty if nothing was done."""
        if self.kind == "none":
            return ""
        if self.kind == "order":
            return "the three channels were put in the order R, G, B"
        if self.kind == "grey":
            what = "one channel" if self.from_channels == 1 else f"{self.from_channels} channels"
            lost = "" if self.from_channels == 1 else ", their mean: .npz keeps them all"
            return f"{what} without a colour became grey, written three times{lost}"
        text = f"{self.from_channels} bands became linear sRGB: the spectrum is lost, .npz keeps it"
        if self.clipped_cells:
            text += (
                f"; {self.clipped_cells} cells ({self.clipped_share:.1%}) lie outside the gamut of "
                f"sRGB: their negative channels (at most {-self.most_negative:.1%} of the cell's "
                f"largest) were set to 0"
            )
        return text


def needs_rgb(table: Table, sheet: FormatSheet) -> bool:
    """Whether `table` must be made R, G, B before the format of `sheet` can hold it."""
    if sheet.colour == "RGB":
        return True
    return sheet.colour == "grey or RGB" and table.n_channels > 1


def rgb_table(table: Table) -> tuple[Table, Conversion]:
    """Return `table` with the channels R, G, B, and how that was done.

    Three channels stay; bands of the visible go through the CIE 1931 observer; anything
    else has no colour and becomes grey.
    """
    from brdfit.render import display_matrix

    matrix = display_matrix(table.n_channels, table.wavelengths, table.channels)
    if matrix.shape == (3, 3) and table.wavelengths is None:
        if np.array_equal(matrix, np.eye(3)):
            return table, Conversion("none", 3)
        return _with_values(table, _times(table, matrix)), Conversion("order", 3)
    rgb = _times(table, np.broadcast_to(matrix, (table.n_channels, 3)))
    if matrix.shape[1] == 1:
        return _with_values(table, rgb), Conversion("grey", table.n_channels)
    return _clipped(table, rgb)


def _times(table: Table, matrix: FloatArray) -> FloatArray:
    rgb = np.zeros((table.grid.size, 3), dtype=np.float32)
    flat = table.values.reshape(-1, table.n_channels)
    # A band without weight may be missing: 0 x NaN must not spread.
    counts = np.any(matrix != 0.0, axis=1)
    for first in range(0, table.grid.size, _BLOCK):
        block = flat[first : first + _BLOCK]
        block = block if counts.all() else block[:, counts]
        rgb[first : first + _BLOCK] = block @ matrix[counts].astype(flat.dtype)
    rgb[~table.mask.reshape(-1)] = 0.0
    return rgb.reshape(*table.grid.shape, 3)


def _clipped(table: Table, rgb: FloatArray) -> tuple[Table, Conversion]:
    cells = rgb[(rgb < 0.0).any(axis=3) & table.mask]
    depth = cells.min(axis=1) / np.maximum(cells.max(axis=1), 1e-12) if len(cells) else np.zeros(1)
    conversion = Conversion(
        kind="spectral",
        from_channels=table.n_channels,
        clipped_cells=len(cells),
        clipped_share=len(cells) / max(int(table.mask.sum()), 1),
        most_negative=float(depth.min()),
    )
    return _with_values(table, np.maximum(rgb, 0.0)), conversion


def _with_values(table: Table, values: FloatArray) -> Table:
    # Read-only and its own: the table takes it without a copy.
    values = np.ascontiguousarray(values)
    values = values.copy() if values.base is not None else values
    values.flags.writeable = False
    return Table(values=values, grid=table.grid, valid=table.valid, source=table.source)
