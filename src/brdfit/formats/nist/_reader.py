"""Read NIST's CSV: one row for each wavelength and pair of directions, in degrees.

thetai is stored negative with phi = 0, which is the light at azimuth 180 degrees; the
specular direction is then at phir = 0. Only the unpolarised element f_r11 is read.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import CorruptFile, UsageError
from brdfit.formats.text import name_lines, parse_rows, read_text
from brdfit.geometry import directions_from_spherical
from brdfit.samples import Flag, Samples, Source

__all__ = ["CONVENTION", "read_samples"]

CONVENTION = (
    "lambda in micrometres; thetai phii toward the light, thetar phir toward the detector, "
    "degrees; thetai negative with phii = 0 is azimuth 180; values are f_r11 in 1/sr"
)

_NEEDED = 6  # lambda, thetai, phii, thetar, phir, f_r11
_SAME = 1e-3  # degrees; the file has at most four decimals


def read_samples(path: Path, *, wavelength: float | None = None) -> Samples:
    """Read the samples; wavelengths measured at the same directions become channels.

    `wavelength`: read only this one, in nm; needed where the directions differ. A sample's
    row is the line of its first wavelength. Rows that cannot be parsed come last, flagged.
    """
    text = read_text(path)
    width = len(text.lines[0][1].split(","))
    data = [item for item in text.lines[1:] if item[1].strip()]
    if not data:
        raise CorruptFile(f"{text.name}: the header is there, but no row of measurements.")
    cells, readable, lines = parse_rows(data, ",", width, range(_NEEDED))
    readable &= np.isfinite(cells[:, :5]).all(axis=1)
    if not readable.any():
        raise CorruptFile(f"{text.name}: none of {len(data)} rows holds numbers.")
    notes = ["unpolarised element f_r11; the other elements of the Mueller matrix are not read"]
    if not readable.all():
        notes.append(name_lines("rows that could not be read", lines[~readable]))
    picked, picked_lines, waves = _pick(text.name, cells[readable], lines[readable], wavelength)
    angles, value, rows = _by_direction(text.name, picked, picked_lines, waves)
    return _build(
        angles, value, rows, lines[~readable], waves, text.source("nist", CONVENTION, notes)
    )


def _pick(
    name: str, cells: FloatArray, lines: IntArray, wavelength: float | None
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Return the rows of the asked wavelengths, and these wavelengths in nm."""
    in_nm = np.round(cells[:, 0] * 1000.0, 6)
    waves = np.unique(in_nm)
    if wavelength is None:
        return cells, lines, waves
    try:
        near = np.abs(waves - float(wavelength))
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"wavelength: found {wavelength!r} but a number in nm is needed."
        ) from error
    if near.min() > 0.5:
        known = ", ".join(f"{wave:g}" for wave in waves)
        raise UsageError(f"wavelength: {name} has none of {wavelength:g} nm. It has: {known} nm.")
    only = in_nm == waves[near.argmin()]
    return cells[only], lines[only], waves[[near.argmin()]]


def _by_direction(
    name: str, cells: FloatArray, lines: IntArray, waves: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return (angles (n, 4) degrees, values (n, wavelengths), first lines (n,)).

    The k-th time that a wavelength has a direction goes with the k-th time of the others,
    so that repeated measurements stay apart.
    """
    channel = np.searchsorted(waves, np.round(cells[:, 0] * 1000.0, 6))
    place_of: dict[tuple[int, ...], int] = {}
    times: dict[tuple[int, ...], int] = {}
    place = np.empty(len(cells), dtype=np.int64)
    for row, key in enumerate(np.rint(cells[:, 1:5] / _SAME).astype(np.int64).tolist()):
        here = (int(channel[row]), *key)
        times[here] = times.get(here, 0) + 1
        place[row] = place_of.setdefault((times[here], *key), len(place_of))
    per_wave = np.bincount(channel, minlength=len(waves))
    if len(place_of) > 1.5 * per_wave.max():
        known = ", ".join(f"{wave:g}" for wave in waves)
        raise UsageError(
            f"{name}: its {len(waves)} wavelengths were measured at different directions, so "
            f"they cannot be channels of one set of samples. Say which: wavelength=... of {known}."
        )
    value = np.full((len(place_of), len(waves)), np.nan)
    value[place, channel] = cells[:, 5]
    _, first = np.unique(place, return_index=True)
    return cells[first, 1:5], value, lines[first]


def _build(
    angles: FloatArray,
    value: FloatArray,
    rows: IntArray,
    unreadable: IntArray,
    waves: FloatArray,
    source: Source,
) -> Samples:
    nothing = np.full((len(unreadable), 4), np.nan)
    theta_i, phi_i, theta_o, phi_o = np.deg2rad(np.vstack([angles, nothing])).T
    marks: BoolArray = np.arange(len(theta_i)) >= len(angles)
    return Samples(
        wi=directions_from_spherical(theta_i, phi_i),
        wo=directions_from_spherical(theta_o, phi_o),
        value=np.vstack([value, np.full((len(unreadable), len(waves)), np.nan)]),
        wavelengths=waves,
        flags=np.where(marks, int(Flag.UNREADABLE), 0),
        rows=np.concatenate([rows, unreadable]),
        source=source,
    )
