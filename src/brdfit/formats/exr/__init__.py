"""OpenEXR atlas: a table as one picture, a slice of it for each phi_d."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.exr_file import MAGIC
from brdfit.formats.sheet import FormatSheet
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["SHEET"]


def _sniff(path: Path, head: bytes) -> bool:
    return head.startswith(MAGIC)


def _read_table(path: Path) -> Table:
    from brdfit.formats.exr.read import read_table

    return read_table(path)


def _read_samples(path: Path, *, count: int | None = None, seed: int = 0) -> Samples:
    from brdfit.formats.drawing import Draw, samples_of_cells
    from brdfit.formats.exr.read import read_table

    return samples_of_cells(read_table(path), Draw(count, seed))


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.exr.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="exr",
    title="OpenEXR atlas of slices",
    extensions=(".exr",),
    specification=(
        "the module brdfit.formats.exr.layout; the slice, theta_h to the right and theta_d upward, "
        "is the image slice of B. Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course "
        "notes; pixels by OpenEXR, https://openexr.com"
    ),
    convention=(
        "a tile for each phi_d, the first at the top left, in rows; in a tile theta_h grows to the "
        "right and theta_d upward, a pixel a node; f_r in 1/sr, NaN where nothing was measured"
    ),
    sniff=_sniff,
    read_samples=_read_samples,
    read_table=_read_table,
    write_table=_write_table,
    options=("count", "seed"),
    loses="digits after the seventh (float32), and the values of cells without a measurement",
    precision=1e-7,
)
"""The data sheet."""
