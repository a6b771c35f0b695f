"""ALTA text: the data files of the ALTA library."""

from __future__ import annotations

import re
from pathlib import Path

from brdfit.formats.alta._parametrisation import PARAMETRISATIONS
from brdfit.formats.alta._reader import read_samples
from brdfit.formats.alta._writer import write_samples
from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head

__all__ = ["SHEET"]

_HEADER = re.compile(r"^#\s*(DIM[ \t]+\d|PARAM_IN\b|ALTA)", re.MULTILINE)


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    return text is not None and bool(_HEADER.search(text.replace("\r", "\n").lstrip("\ufeff")))


SHEET = FormatSheet(
    name="alta",
    title="ALTA text",
    extensions=(".alta",),
    specification="ALTA library, Belcour, Barla, Pacanowski, https://alta.gforge.inria.fr",
    convention=(
        "#PARAM_IN names the coordinates, in radians ("
        + ", ".join(PARAMETRISATIONS)
        + "); L is the light, V the detector; values are f_r in 1/sr, divided by cos theta_v "
        "where #PARAM_OUT says that they are weighted by it"
    ),
    sniff=_sniff,
    read_samples=read_samples,
    write_samples=write_samples,
    loses=(
        "all but one channel or RGB (more are refused), standard deviations, wavelengths, samples "
        "that were marked as unreadable or rejected (left out, with a warning), and row numbers"
    ),
)
"""The data sheet."""
