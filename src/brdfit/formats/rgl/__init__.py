"""RGL's `.bsdf`: adaptive measurements of the EPFL material database."""

from __future__ import annotations

from pathlib import Path

from brdfit.errors import UsageError
from brdfit.formats.sheet import FormatSheet
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["SHEET"]

CONVENTION = (
    "directions from the warped nodes, radians; the file holds f_r cos(theta_o), divided here "
    "once; wi is the direction the nodes are conditioned on"
)


def _sniff(path: Path, head: bytes) -> bool:
    return head.startswith(b"tensor_file\0")


def _read_samples(path: Path, *, half: bool = False, extrapolate: bool = False) -> Samples:
    if extrapolate:
        raise UsageError("extrapolate=True fills cells of a table; samples have none to fill.")
    from brdfit.formats.rgl.read import read_samples

    return read_samples(path, half=half)


def _read_table(path: Path, *, half: bool = False, extrapolate: bool = False) -> Table:
    if half:
        raise UsageError("half=True leaves samples out; a table is always read from all of them.")
    from brdfit.formats.rgl.read import read_table

    return read_table(path, extrapolate=extrapolate)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.rgl.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="rgl",
    title="RGL material database, isotropic (.bsdf tensor file)",
    extensions=(".bsdf",),
    specification=(
        'J. Dupuy and W. Jakob, "An Adaptive Parameterization for Efficient Material '
        'Acquisition and Rendering", ACM Trans. Graph. 37(6), 2018'
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    read_table=_read_table,
    write_table=_write_table,
    options=("half", "extrapolate"),
    loses=(
        "the grid (values at 12 to 96 incidences and 24 x 24 to 160 x 160 nodes for each, which "
        "lie where the material changes; the coarsest that is within 1 % of the table in the "
        "mean), "
        "digits after the seventh, the difference between one channel and three equal ones, and "
        "which cells are missing"
    ),
    precision=0.01,
    averages=True,
    competes_for=("Zemax BSDF (text)", "LightTools BSDF (text)"),
)
