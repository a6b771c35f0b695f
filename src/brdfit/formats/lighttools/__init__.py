"""LightTools' tabular BSDF (`.bsdf` text): polar and azimuthal angles about the normal."""

from __future__ import annotations

import re
from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head
from brdfit.samples import Samples

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
    options=("light_azimuth",),
    competes_for=("rgl", "zemax"),
)
"""The data sheet."""
