"""LightTools' tabular BSDF (`.bsdf` text): polar and azimuthal angles about the normal."""

from __future__ import annotations

import re
from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["CONVENTION", "SHEET"]

CONVENTION = (
    "degrees; AOI is the polar angle of the light, at azimuth POI + 90; ScatterRadial and "
    "ScatterAzimuth are the detector's polar angle and azimuth about the normal; values are f_r in "
    "1/sr"
)

_ANGLES = re.compile(r"^[ \t]*Scatter(Radial|Azimuth)\b", re.MULTILINE | re.IGNORECASE)
_BLOCK = re.compile(r"^[ \t]*AOI\b", re.MULTILINE | re.IGNORECASE)
_ZEMAX = re.compile(r"^[ \t]*AngleOfIncidence\b", re.MULTILINE | re.IGNORECASE)


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    if text is None:
        return False
    text = text.replace("\r", "\n")
    return bool(_ANGLES.search(text)) and bool(_BLOCK.search(text)) and not _ZEMAX.search(text)


def _read_samples(path: Path, *, light_azimuth: float = 90.0) -> Samples:
    from brdfit.formats.lighttools.read import read_samples

    return read_samples(path, light_azimuth=light_azimuth)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.lighttools.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="lighttools",
    title="LightTools tabular BSDF (text)",
    extensions=(".bsdf",),
    specification=(
        "LightTools, data file of the user-defined BSDF; known to us by what the reader of "
        "libbsdf (K. Ryo, https://github.com/KimuraRyo/libbsdf) accepts"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    write_table=_write_table,
    colour="grey or RGB",
    options=("light_azimuth",),
    loses=(
        "all but one channel or RGB (written as XYZ; more are refused), the grid (values at 18 "
        "incidences to 85 degrees, 81 azimuths of 5 degrees and less, and polar angles every "
        "degree to 88), digits after the eighth, values below zero (written as zero, with a "
        "warning), and where the table came from; a channel without a wavelength is said to be "
        "at 550 nm"
    ),
    precision=5e-7,
    competes_for=("rgl", "zemax"),
)
"""The data sheet."""
