"""NIST's CSV of sintered PTFE (bidirectional Mueller matrices)."""

from __future__ import annotations

import re
from pathlib import Path

from brdfit.formats.nist._reader import CONVENTION, read_samples
from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head

__all__ = ["SHEET"]

_HEADER = re.compile(r"lambda\s*,\s*thetai\s*,\s*phii?\s*,\s*thetar\s*,\s*phir\s*,")


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    return text is not None and bool(_HEADER.match(text.lstrip("\ufeff").lower()))


SHEET = FormatSheet(
    name="nist",
    title="NIST CSV of Mueller-matrix BRDFs (sintered PTFE)",
    extensions=(".csv",),
    specification=(
        "Germer, Full four-dimensional and reciprocal Mueller matrix bidirectional reflectance "
        "distribution function of sintered polytetrafluoroethylene, Applied Optics 56, 2017"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=read_samples,
    options=("wavelength",),
    competes_for=("delimited",),
)
"""The data sheet."""
