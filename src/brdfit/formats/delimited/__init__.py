"""Delimited text with declared columns: CSV, TSV, blanks; and our own CSV of samples."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.declaration import Declaration
from brdfit.formats.delimited._layout import LAYOUT_OPTIONS, looks_delimited
from brdfit.formats.delimited._reader import read_samples
from brdfit.formats.delimited._writer import OWN_PREFIX, write_samples
from brdfit.formats.sheet import FormatSheet
from brdfit.formats.sidecar import find_sidecar
from brdfit.formats.text import decode_head

__all__ = ["SHEET"]


def _sniff(path: Path, head: bytes) -> bool:
    text = decode_head(head)
    if text is None:
        return False
    if text.lstrip("\ufeff").startswith(OWN_PREFIX) or find_sidecar(path) is not None:
        return True
    if path.suffix.lower() in (".csv", ".tsv"):
        return looks_delimited(text, fewest=2)
    return looks_delimited(text)


SHEET = FormatSheet(
    name="delimited",
    title="delimited text with declared columns (CSV, TSV, blanks)",
    extensions=(".csv", ".tsv", ".txt", ".dat"),
    specification="docs/formats.md, section on declared columns",
    convention=(
        "declared by a TOML sidecar or options: coordinates, degrees or radians, light side, "
        "cosine; own files hold unit vectors and f_r in 1/sr"
    ),
    sniff=_sniff,
    read_samples=read_samples,
    write_samples=write_samples,
    options=(*Declaration.option_names(), *LAYOUT_OPTIONS),
    competes_for=("nist", "curet"),
)
"""The data sheet."""
