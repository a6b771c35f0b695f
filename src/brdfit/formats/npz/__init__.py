"""brdfit's own `.npz`: samples and tables, without loss."""

from __future__ import annotations

from pathlib import Path

from brdfit.formats.sheet import FormatSheet
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["SHEET"]


def _sniff(path: Path, head: bytes) -> bool:
    return head.startswith(b"PK") and (path.suffix.lower() == ".npz" or b"brdfit.npy" in head[:64])


def _read_samples(path: Path) -> Samples:
    from brdfit.formats.npz.read import read_samples

    return read_samples(path)


def _read_table(path: Path) -> Table:
    from brdfit.formats.npz.read import read_table

    return read_table(path)


def _write_samples(samples: Samples, path: Path) -> None:
    from brdfit.formats.npz.write import write_samples

    write_samples(samples, path)


def _write_table(table: Table, path: Path) -> None:
    from brdfit.formats.npz.write import write_table

    write_table(table, path)


SHEET = FormatSheet(
    name="npz",
    title="brdfit samples or table (NumPy .npz)",
    extensions=(".npz",),
    specification="docs/formats.md, and the module brdfit.formats.npz.layout",
    convention=(
        "unit vectors wi (toward the light) and wo, or values on a half/difference grid; f_r in "
        "1/sr, cosine not included"
    ),
    sniff=_sniff,
    read_samples=_read_samples,
    read_table=_read_table,
    write_samples=_write_samples,
    write_table=_write_table,
)
