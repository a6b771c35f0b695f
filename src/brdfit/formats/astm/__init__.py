"""ASTM E1392 text, as Cornell's gonioreflectometer wrote it."""

from __future__ import annotations

import re
from pathlib import Path

from brdfit.formats.astm._reader import CONVENTION, read_samples
from brdfit.formats.astm._writer import write_samples
from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head

__all__ = ["SHEET"]

_VARS = re.compile(r"^VARS[ \t]", re.MULTILINE)
_KEYS = re.compile(r"^(LAB_NAME|SAMPLE_NAME|MEAS_NAME|NUM_POINTS|SYSTEM_NAME)\b", re.MULTILINE)


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    if text is None:
        return False
    text = text.replace("\r\n", "\n").replace("\r", "\n").lstrip("\ufeff")
    return bool(_KEYS.search(text)) and (bool(_VARS.search(text)) or len(_KEYS.findall(text)) > 1)


SHEET = FormatSheet(
    name="astm",
    title="ASTM E1392 text (Cornell's gonioreflectometer)",
    extensions=(".astm",),
    specification=(
        "ASTM E1392; Foo, A Gonioreflectometer for Measuring the Bidirectional Reflectance of "
        "Materials for Use in Illumination Computation, Cornell University, 1997"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=read_samples,
    write_samples=write_samples,
    options=("angles",),
    loses=(
        "samples that were marked as unreadable or rejected (left out, with a warning), row "
        "numbers, names of channels that have wavelengths, and the notes of their reader"
    ),
    precision=1e-12,
)
"""The data sheet."""
