"""Radiance's tensor tree (XML): a BSDF on the Shirley-Chiu square, isotropic or not."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.formats.window_xml import structure_in
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["CONVENTION", "SHEET"]

CONVENTION = (
    "the sine of the light's polar angle, and the detector's projection onto the disk, mapped to "
    "the square (Shirley and Chiu), with the light at azimuth 180 degrees; values are f_r in 1/sr"
)


def _sniff(path: Path, head: bytes) -> bool:
    return structure_in(head).startswith("tensortree")


def _read_samples(path: Path) -> Samples:
    from brdfit.formats.tensortree.read import read_samples

    return read_samples(path)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.tensortree.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="tensortree",
    title="Radiance tensor tree (XML)",
    extensions=(".xml",),
    specification=(
        "G. Ward, M. Kurt, N. Bonneel, Reducing Anisotropic BSDF Measurement to Common Practice, "
        "Workshop on Material Appearance Modeling 2014; bsdf_t.c in the source of Radiance"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    write_table=_write_table,
    colour="grey or RGB",
    loses=(
        "all but luminance (of RGB, with a warning; more channels are refused), the grid (values "
        "at the middles of 32 sines of incidence x 64 x 64 cells of the disk, some 2 degrees), "
        "values below zero (written as zero, with a warning), and where the table came from"
    ),
    precision=2e-5,
    competes_for=("klems",),
)
"""The data sheet."""
