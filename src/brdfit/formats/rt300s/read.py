"""Read a measurement of the RT-300S and subtract its blank.

The instrument reports RT, the received light relative to its white standard. Stray light and
the offset of the detector are measured without a sample, the *blank*; what remains is divided
by pi and by the cosine of the detector:

    f_r = (RT - RT_blank) / (pi cos R)

The detector turns in the plane y = 0 by the angle R (Receive), positive toward +x. The light
stands at the polar angle I (Incidence) in a plane turned by A (Azimuth):

    wo = (sin R, 0, cos R)        wi = (sin I cos(A - 90), sin I sin(A - 90), cos I)

so that at A = -90 the specular direction is at R = I. The sense of A is not documented: a
material that is its own mirror image, as nearly all are, does not tell.

Where the detector passes the light it stands in its beam. In the files that we have RT drops
to nothing there within some 5 degrees; these samples are flagged `REJECTED`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray, dot, safe_arccos
from brdfit.errors import FormatError, UsageError
from brdfit.formats.rt300s import CONVENTION
from brdfit.formats.rt300s.workbook import Workbook, read_workbook
from brdfit.geometry import directions_from_spherical
from brdfit.samples import Flag, Samples, Source

__all__ = ["read_samples"]

_SAME = 1e-3  # degrees
_FEWEST_SHARED = 0.5


def read_samples(
    path: Path, *, blank: str | Path | bool | None, obscured: float, wavelength: float | None
) -> Samples:
    """Read the samples of an RT-300S workbook.

    Parameters: `blank`, the workbook of the blank measurement, beside `path` unless it is a
    whole path; left out, the one workbook beside `path` whose name begins with "blank";
    False, nothing is subtracted. `obscured`, samples whose detector is nearer to the light
    than this (degrees) are rejected. `wavelength` of the laser in nm, which the file does
    not hold.

    A sample whose directions the blank lacks has no value. `rows` are 1-based columns of the
    workbook, counted over its sheets.
    """
    if not isinstance(obscured, int | float) or not 0.0 <= obscured < 90.0:
        raise UsageError(f"obscured: found {obscured!r} but degrees from 0 to 90 are needed.")
    if wavelength is not None and not (isinstance(wavelength, int | float) and wavelength > 0.0):
        raise UsageError(f"wavelength: found {wavelength!r} but a number in nm is needed.")
    book = read_workbook(path)
    zero, notes = _zero(path, book, blank)
    azimuth, incidence, receive = np.deg2rad(book.angles).T
    wi = directions_from_spherical(incidence, azimuth - np.pi / 2)
    wo = directions_from_spherical(receive, np.zeros_like(receive))
    cos_r = np.where(wo[:, 2] > 0.0, wo[:, 2], 1.0)
    readable: BoolArray = np.asarray(np.isfinite(book.angles).all(axis=1))
    hidden = readable & (np.rad2deg(safe_arccos(dot(wi, wo))) < obscured)
    if hidden.any():
        notes.append(
            f"{int(hidden.sum())} samples rejected: the detector stands within {obscured:g} "
            f"degrees of the light, in its beam"
        )
    return Samples(
        wi=wi,
        wo=wo,
        value=((book.rt - zero) / (np.pi * cos_r))[:, None],
        wavelengths=None if wavelength is None else np.array([float(wavelength)]),
        flags=_flags(readable, hidden),
        rows=book.columns,
        source=Source(
            name=book.name,
            format="rt300s",
            sha256=book.sha256,
            convention=CONVENTION,
            notes=tuple(notes),
            metadata=book.metadata,
        ),
    )


def _flags(readable: BoolArray, hidden: BoolArray) -> IntArray:
    unreadable = np.where(readable, 0, int(Flag.UNREADABLE))
    return np.asarray(unreadable | np.where(hidden, int(Flag.REJECTED), 0))


def _zero(
    path: Path, book: Workbook, blank: str | Path | bool | None
) -> tuple[FloatArray, list[str]]:
    """Return the RT (n,) to subtract from each sample, and what is to be said of it."""
    chosen = _blank_file(path, blank)
    if chosen is None:
        note = "no blank subtracted: the values hold the stray light of the instrument"
        return np.zeros(len(book.rt)), [note]
    zero = read_workbook(chosen)
    # the last of repeated directions counts
    at = dict(zip(_keys(zero.angles), zero.rt.tolist(), strict=True))
    found = np.array([at.get(key, np.nan) for key in _keys(book.angles)])
    missing = int(np.count_nonzero(np.isnan(found)))
    if missing > _FEWEST_SHARED * len(found):
        raise FormatError(
            f"{path.name}: the blank {chosen.name} lacks {missing} of its {len(found)} pairs of "
            f"directions. A blank must be measured at the same angles; name another one with "
            f"blank=..., or read without with blank=False."
        )
    notes = [f"blank subtracted: {chosen.name} (SHA-256 {zero.sha256[:16]})"]
    if missing:
        notes.append(f"{missing} samples have no value: the blank lacks their directions")
    return found, notes


def _keys(angles: FloatArray) -> list[tuple[int, ...] | None]:
    """Return a key for each row of angles (n, 3); None where one is missing."""
    whole: BoolArray = np.asarray((np.abs(angles) < 1e6).all(axis=1))
    steps = np.rint(np.where(whole[:, None], angles, 0.0) / _SAME).astype(np.int64).tolist()
    return [tuple(row) if good else None for row, good in zip(steps, whole, strict=True)]


def _blank_file(path: Path, blank: str | Path | bool | None) -> Path | None:
    if blank is False:
        return None
    if blank is None or blank is True:
        return _blank_beside(path)
    chosen = path.parent / blank
    if not chosen.is_file():
        raise FormatError(f"{chosen.name}: no such file, but blank= names it for {path.name}.")
    return chosen


def _blank_beside(path: Path) -> Path:
    beside = [
        file
        for file in sorted(path.parent.glob("*.[xX][lL][sS]"))
        if file.name.lower().startswith("blank") and file.name != path.name
    ]
    if len(beside) == 1:
        return beside[0]
    found = f"{len(beside)} ({', '.join(file.name for file in beside[:5])})" if beside else "none"
    raise UsageError(
        f"{path.name}: a measurement of the RT-300S needs its blank, and of workbooks whose name "
        f"begins with 'blank' there is {found} beside it. Name it with blank=..., or read without "
        f"with blank=False (on the command line --option blank=FILE or blank=false)."
    )
