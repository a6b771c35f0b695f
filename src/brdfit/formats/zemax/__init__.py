"""Zemax's tabular BSDF (`.bsdf` text): angles about the specular direction."""

from __future__ import annotations

import re
from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["CONVENTION", "SHEET"]

CONVENTION = (
    "degrees; ScatterRadial is the angle from the specular direction, ScatterAzimuth turns about "
    "it, 0 toward the normal; values are f_r in 1/sr"
)

_ANGLES = re.compile(r"^[ \t]*AngleOfIncidence\b", re.MULTILINE | re.IGNORECASE)
_KEYS = re.compile(r"^[ \t]*(Symmetry|SpectralContent|ScatterType)\b", re.MULTILINE | re.IGNORECASE)


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    if text is None:
        return False
    text = text.replace("\r", "\n")
    return bool(_ANGLES.search(text)) and bool(_KEYS.search(text))


def _read_samples(path: Path, *, zeros: str = "missing") -> Samples:
    from brdfit.formats.zemax.read import read_samples

    return read_samples(path, zeros=zeros)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.zemax.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="zemax",
    title="Zemax tabular BSDF (text)",
    extensions=(".bsdf",),
    specification=(
        "R. Rykowski, Zemax Tabular BSDF data file format (BSDF Data Interchange File Format), "
        "https://support.zemax.com/hc/en-us/articles/1500005486801"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    write_table=_write_table,
    colour="grey or RGB",
    options=("zeros",),
    loses=(
        "all but one channel or RGB (written as XYZ; more are refused), the grid (values at 18 "
        "incidences to 85 degrees, 29 radial angles to 175 and azimuths every 10 degrees), digits "
        "after the eighth, values below zero (written as zero, with a warning), and where the "
        "table came from"
    ),
    precision=5e-7,
    competes_for=("rgl", "lighttools"),
)
"""The data sheet."""
