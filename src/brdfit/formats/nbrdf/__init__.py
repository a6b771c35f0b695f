"""NBRDF: a material in the weights of a small network (`.h5`), or an archive of them (`.zip`)."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["SHEET"]

CONVENTION = (
    "inputs are the half and the difference vector, half vector at azimuth 0, phi_d in [0, pi) by "
    "reciprocity; outputs become f_r = max(exp(y) - 1, 0), linear sRGB, 1/sr"
)

_HDF = b"\x89HDF\r\n\x1a\n"


def _sniff(path: Path, head: bytes) -> bool:
    return head.startswith(_HDF) or (head.startswith(b"PK\x03\x04") and b".h5" in head)


def _read_table(path: Path, *, material: str | None = None) -> Table:
    from brdfit.formats.nbrdf.read import read_table

    return read_table(path, material)


def _read_samples(
    path: Path, *, material: str | None = None, count: int | None = None, seed: int = 0
) -> Samples:
    from brdfit.formats.drawing import Draw
    from brdfit.formats.nbrdf.read import read_samples

    return read_samples(path, material, Draw(count, seed))


SHEET = FormatSheet(
    name="nbrdf",
    title="NBRDF network weights (Keras .h5, or a .zip of them)",
    extensions=(".h5", ".zip"),
    specification=(
        "A. Sztrajman, G. Rainer, T. Ritschel, T. Weyrich, Neural BRDF Representation and "
        "Importance Sampling, Computer Graphics Forum 40(6), 2021; "
        "https://github.com/asztr/Neural-BRDF"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    read_table=_read_table,
    options=("material", "count", "seed"),
)
"""The data sheet."""
