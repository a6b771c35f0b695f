"""Klems matrices (XML): 145 x 145 patches of directions, for WINDOW and Radiance."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.formats.window_xml import structure_in
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["CONVENTION", "SHEET"]

CONVENTION = (
    "patches of directions about the normal, the light's turned by 180 degrees so that equal "
    "numbers are mirror directions; values are means of f_r over pairs of patches, 1/sr"
)


def _sniff(path: Path, head: bytes) -> bool:
    return structure_in(head) in ("columns", "rows")


def _read_samples(path: Path) -> Samples:
    from brdfit.formats.klems.read import read_samples

    return read_samples(path)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.klems.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="klems",
    title="Klems matrix (XML of WINDOW and Radiance)",
    extensions=(".xml",),
    specification=(
        "J. H. Klems, A New Method for Predicting the Solar Heat Gain of Complex Fenestration "
        "Systems, ASHRAE Transactions 100, 1994; bsdf_m.c in the source of Radiance"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    write_table=_write_table,
    colour="grey or RGB",
    loses=(
        "all but one channel or RGB (written as XYZ; more are refused), the grid (means over 145 x "
        "145 patches of some 10 to 15 degrees: a lobe narrower than that is spread), values below "
        "zero (written as zero, with a warning), and where the table came from"
    ),
    precision=0.01,
    averages=True,
    competes_for=("tensortree",),
)
"""The data sheet."""
