"""UTIA BRDF database (`.bin`): anisotropic, 6 x 48 directions of the light and of the detector."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.formats.sheet import FormatSheet
from brdfit.formats.utia.layout import CONVENTION, FILE_BYTES
from brdfit.samples import Samples

__all__ = ["SHEET"]

# Stored numbers are between these in size, or zero; text or another binary is far outside.
_SMALLEST, _LARGEST = 1e-15, 1e9


def _sniff(path: Path, head: bytes) -> bool:
    try:
        size = path.stat().st_size
    except OSError:
        return False
    # a cut file is recognised by its suffix, so that the reader can say what is missing
    kinds = [kind for kind, whole in FILE_BYTES.items() if size == whole]
    if not kinds and path.suffix.lower() == ".bin":
        kinds = list(FILE_BYTES)
    return any(_plausible(head, kind) for kind in kinds)


def _plausible(head: bytes, kind: str) -> bool:
    width = np.dtype(kind).itemsize
    with np.errstate(all="ignore"):
        numbers = np.abs(np.frombuffer(head[: len(head) // width * width], kind).astype(float))
    sized = (numbers >= _SMALLEST) & (numbers <= _LARGEST)
    return bool(sized.any() and (sized | (numbers == 0.0)).all())


def _read_samples(
    path: Path,
    *,
    encoding: str = "linear",
    white: float = 1.0,
    scale: float = 1.0,
    count: int | None = None,
    seed: int = 0,
) -> Samples:
    from brdfit.formats.utia.read import Meaning, read_samples

    return read_samples(path, Meaning(encoding, white, scale), count, seed)


SHEET = FormatSheet(
    name="utia",
    title="UTIA BRDF database (.bin, anisotropic)",
    extensions=(".bin",),
    specification=(
        "J. Filip, R. Vavra, Template-Based Sampling of Anisotropic BRDFs, Computer Graphics Forum "
        "33(7), 2014; the layout after J. Filip's own reader, as ALTA (data_utia) and dj_brdf "
        "(https://github.com/jdupuy/dj_brdf) have it. The unit of the numbers is not documented: "
        "by default they are f_r as they stand; encoding=srgb, white=140, scale=100 is the reading "
        "of dj_brdf"
    ),
    convention=CONVENTION,
    sniff=_sniff,
    read_samples=_read_samples,
    options=("encoding", "white", "scale", "count", "seed"),
)
"""The data sheet."""
