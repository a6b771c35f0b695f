"""Parquet with declared columns, and our own Parquet of samples."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.declaration import Declaration
from brdfit.formats.parquet._io import read_samples, write_samples
from brdfit.formats.sheet import FormatSheet

__all__ = ["SHEET"]


def _sniff(path: Path, head: bytes) -> bool:
    return head[:4] == b"PAR1"


SHEET = FormatSheet(
    name="parquet",
    title="Parquet with declared columns",
    extensions=(".parquet", ".pq"),
    specification="https://parquet.apache.org/docs/file-format/",
    convention=(
        "declared by a TOML sidecar or options: coordinates, degrees or radians, light side, "
        "cosine; own files hold unit vectors and f_r in 1/sr"
    ),
    sniff=_sniff,
    read_samples=read_samples,
    write_samples=write_samples,
    options=Declaration.option_names(),
)
"""The data sheet."""
