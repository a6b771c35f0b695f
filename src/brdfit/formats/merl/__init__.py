"""MERL's `.binary`: dense RGB tables on the 90 x 90 x 180 grid."""

from __future__ import annotations

import struct
from pathlib import Path

from brdfit.errors import UsageError
from brdfit.formats.merl.layout import CONVENTION, HEADER
from brdfit.formats.sheet import FormatSheet
from brdfit.grid import MERL_GRID
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["SHEET"]

# A header of three plausible sizes, though perhaps not the right ones.
_MOST_NODES = 100_000


def _sniff(path: Path, head: bytes) -> bool:
    if head.startswith(struct.pack("<3i", *HEADER)):
        return True
    if path.suffix.lower() != ".binary":
        return False
    if len(head) < 12:
        return True
    return any(
        all(0 < size < _MOST_NODES for size in struct.unpack(f"{order}3i", head[:12]))
        for order in "<>"
    )


def _read_table(path: Path, *, count: int | None = None, seed: int = 0) -> Table:
    if count is not None:
        raise UsageError("count draws a subset of samples; a table is always read whole.")
    from brdfit.formats.merl.read import read_table

    return read_table(path)


def _read_samples(path: Path, *, count: int | None = None, seed: int = 0) -> Samples:
    from brdfit.formats.merl.read import read_samples

    return read_samples(path, count=count, seed=seed)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.merl.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="merl",
    title="MERL BRDF database (.binary)",
    extensions=(".binary",),
    specification=(
        "W. Matusik, H. Pfister, M. Brand, L. McMillan, "
        '"A Data-Driven Reflectance Model", ACM Trans. Graph. 22(3), 2003'
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    read_table=_read_table,
    write_table=_write_table,
    colour="RGB",
    grid=MERL_GRID,
    options=("count", "seed"),
    precision=3e-16,
    loses=(
        "all but RGB (one channel is written three times, more are refused), other grids "
        "(refused), values below zero (written as zero, with a warning), and where the table "
        "came from"
    ),
)
