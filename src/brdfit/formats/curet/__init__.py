"""CUReT: 61 real-world surfaces at 205 pairs of directions."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.curet._reader import CONVENTION, DIRECTIONS, read_samples
from brdfit.formats.sheet import FormatSheet
from brdfit.formats.text import decode_head, parse_number

__all__ = ["SHEET"]


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    if text is None:
        return False
    fields = text.lstrip("\ufeff").lstrip().replace("\r", "\n").split("\n")[0].split()
    return (
        len(fields) == DIRECTIONS + 1
        and fields[0].isdigit()
        and all(parse_number(field) is not None for field in fields)
    )


SHEET = FormatSheet(
    name="curet",
    title="CUReT BRDF measurements (a row of 205 values for each material)",
    extensions=(".dat",),
    specification=(
        "Dana, van Ginneken, Nayar, Koenderink, Reflectance and Texture of Real-World Surfaces, "
        "ACM Transactions on Graphics 18, 1999"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=read_samples,
    options=("material", "directions_file"),
    competes_for=("delimited",),
)
"""The data sheet."""
