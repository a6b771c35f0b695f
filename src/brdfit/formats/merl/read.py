"""Read MERL `.binary` files."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from brdfit.errors import CorruptFile
from brdfit.files import sha256_of_bytes
from brdfit.formats.drawing import Draw, samples_of_cells
from brdfit.formats.merl.layout import CONVENTION, FILE_BYTES, HEADER, HEADER_BYTES, SCALES
from brdfit.grid import MERL_GRID
from brdfit.samples import Samples, Source
from brdfit.table import Table

__all__ = ["read_samples", "read_table"]

_AXES = ("theta_h", "theta_d", "phi_d")


def read_table(path: Path) -> Table:
    """Return the table of a file.

    A cell is valid if it is above the horizon and all three of its channels are finite and
    >= 0. All other cells keep what the file holds (scaled), are masked, and those above the
    horizon are counted in `source.notes`.

    Raises `CorruptFile` if a dimension or the number of bytes is not as it must be.
    """
    with open(path, "rb") as stream:
        header = stream.read(HEADER_BYTES)
    _check_header(header, path)
    _check_size(path.stat().st_size, path)
    content = path.read_bytes()
    _check_size(len(content), path)
    planes = np.frombuffer(content, "<f8", 3 * MERL_GRID.size, HEADER_BYTES)
    planes = planes.reshape(3, *MERL_GRID.shape)
    values = np.empty((*MERL_GRID.shape, 3))
    for channel, scale in enumerate(SCALES):
        np.multiply(planes[channel], scale, out=values[..., channel])
    values.flags.writeable = False
    # a NaN compares false, so it is not valid either
    valid = np.all((values >= 0.0) & np.isfinite(values), axis=-1)
    missing = int(np.count_nonzero(MERL_GRID.above_horizon & ~valid))
    notes = (
        f"{missing:,} of {MERL_GRID.cells.size:,} cells above the horizon are not measured "
        f"(a channel is negative or not finite); they are masked",
    )
    source = Source(
        name=path.name,
        format="merl",
        sha256=sha256_of_bytes(content),
        convention=CONVENTION,
        notes=notes if missing else (),
    )
    return Table(values, valid=np.asarray(valid), source=source)


def read_samples(path: Path, *, count: int | None = None, seed: int = 0) -> Samples:
    """Return the valid cells as samples at the directions of their nodes.

    `count` draws that many of the 1.1 million at random, without repetition, by `seed`;
    `rows` are 1-based cell numbers in the order of the file.
    """
    return samples_of_cells(read_table(path), Draw(count, seed))


def _check_header(header: bytes, path: Path) -> None:
    if len(header) < HEADER_BYTES:
        raise CorruptFile(
            f"{path.name}: has {len(header)} bytes but a MERL table has {FILE_BYTES:,}, of which "
            f"{HEADER_BYTES} say its dimensions. It is truncated; fetch it again."
        )
    found = struct.unpack("<3i", header)
    if found == HEADER:
        return
    if struct.unpack(">3i", header) == HEADER:
        raise CorruptFile(
            f"{path.name}: is big-endian but a MERL table is little-endian. Swap its bytes."
        )
    wrong = ", ".join(
        f"{axis} is {size} instead of {expected}"
        for axis, size, expected in zip(_AXES, found, HEADER, strict=True)
        if size != expected
    )
    raise CorruptFile(
        f"{path.name}: found the dimensions {found[0]} x {found[1]} x {found[2]} but a MERL table "
        f"has 90 x 90 x 180 ({wrong}). The file is damaged, or a table of another resolution; "
        f"write those as .npz."
    )


def _check_size(size: int, path: Path) -> None:
    if size == FILE_BYTES:
        return
    as_float32 = HEADER_BYTES + 3 * MERL_GRID.size * 4
    one_plane = HEADER_BYTES + MERL_GRID.size * 8
    causes = {
        as_float32: "It is half the size: stored as float32, or cut in the middle",
        one_plane: "It holds one channel only, or was cut after the first",
    }
    short = "It looks truncated" if size < FILE_BYTES else "Something was appended to it"
    raise CorruptFile(
        f"{path.name}: has {size:,} bytes but a 90 x 90 x 180 table of three float64 channels has "
        f"{FILE_BYTES:,}. {causes.get(size, short)}; fetch or write it again."
    )
