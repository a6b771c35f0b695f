"""Which columns of a table of measurements mean what.

The same keys in three places: a TOML file beside the data (`name.csv.toml` or `name.toml`),
keyword options of `read_samples`, options of the command line. Later ones win.

    directions = ["theta_i", "phi_i", "theta_o", "phi_o"]   # names, or 1, 2, ... = position
    angles = "degrees"
    values = ["400nm", "500nm"]

The mathematics is that of `brdfit.geometry`; nothing here knows whether the columns came
from text or Parquet.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_half_diff, directions_from_spherical
from brdfit.samples import Flag, Samples, Source

__all__ = [
    "COORDINATES",
    "OWN_FLAGS",
    "Column",
    "Declaration",
    "coerce",
    "position_of",
    "samples_from",
    "wavelength_of",
]

Column = str | int
"""A column by name or by 1-based position; "=30" is the constant 30 in place of a column."""

COORDINATES = {
    "spherical": ("theta_i", "phi_i", "theta_o", "phi_o"),
    "relative": ("theta_i", "theta_o", "phi_o - phi_i"),
    "half_difference": ("theta_h", "theta_d", "phi_d"),
    "vectors": ("wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"),
}
"""Kinds of coordinates and what their columns are, in this order."""

OWN_FLAGS = "brdfit_flags"
"""A flag column of this name holds the bits of `Flag`; any other marks rejected rows."""

_BY_COUNT = {3: "half_difference", 4: "spherical", 6: "vectors"}
_TRUE = {"true", "yes", "1", "on"}
_FALSE = {"false", "no", "0", "off"}


@dataclass(frozen=True)
class Declaration:
    """What the columns of a file of measurements mean; every row is one measurement."""

    directions: tuple[Column, ...]
    """Columns of the two directions, in the order of `COORDINATES[coordinates]`."""
    values: tuple[Column, ...]
    """Columns of f_r in 1/sr, one for each channel."""
    coordinates: str = ""
    """A key of `COORDINATES`; from the number of columns if empty (3: half_difference)."""
    angles: str = ""
    """"degrees" or "radians"; must be said unless the directions are vectors."""
    sigma: tuple[Column, ...] = ()
    """Columns of the standard deviation, one for each channel, or one for all."""
    wavelengths: tuple[float, ...] = ()
    """Wavelength of each channel in nm; read from names such as 400nm if empty."""
    channels: tuple[str, ...] = ()
    """Names of the channels; the names of the value columns if empty."""
    light: str = "first"
    """Which of the two directions points toward the light: "first" (the i, or theta_d's own)
    or "second"."""
    cosine_weighted: bool = False
    """The values are f_r times the cosine of the *detector's* polar angle; divide by it."""
    flags: Column | None = None
    """Column that marks wrong measurements (not 0 = rejected); optional."""

    def __post_init__(self) -> None:
        kind = self.coordinates or _BY_COUNT.get(len(self.directions), "")
        if kind not in COORDINATES or len(COORDINATES[kind]) != len(self.directions):
            wanted = "; ".join(f"{name}: {', '.join(of)}" for name, of in COORDINATES.items())
            raise UsageError(
                f"directions: found {len(self.directions)} columns"
                f"{f' for coordinates = {self.coordinates!r}' if self.coordinates else ''}, "
                f"but expected one of: {wanted}."
            )
        object.__setattr__(self, "coordinates", kind)
        _one_of("angles", self.angles, ("degrees", "radians", ""))
        _one_of("light", self.light, ("first", "second"))
        if kind != "vectors" and not self.angles:
            raise UsageError(
                'angles: must be declared as "degrees" or "radians" for '
                f"{kind} coordinates; a wrong guess would spoil every sample."
            )
        n = len(self.values)
        if n == 0:
            raise UsageError("values: found no column, but at least one column of f_r is needed.")
        for name in ("wavelengths", "channels"):
            found = len(getattr(self, name))
            if found not in (0, n):
                raise UsageError(f"{name}: found {found} for {n} value columns; give one each.")
        if len(self.sigma) not in (0, 1, n):
            raise UsageError(
                f"sigma: found {len(self.sigma)} columns for {n} value columns; give one for "
                f"each, or one for all."
            )

    @classmethod
    def option_names(cls) -> tuple[str, ...]:
        """Return the keys of the sidecar and the options that a declaration consists of."""
        return tuple(field.name for field in fields(cls))

    @classmethod
    def from_options(cls, options: Mapping[str, Any], where: str) -> Declaration:
        """Return the declaration that raw options make; `where` names them in an error.

        Lists may be given as one comma-separated string, as a command line does.
        """
        missing = [name for name in ("directions", "values") if name not in options]
        if missing:
            raise UsageError(f"{where}: {' and '.join(missing)} must be declared too.")
        return cls(**{name: coerce(name, value, where) for name, value in options.items()})

    def convention(self) -> str:
        """Return the declared convention in words."""
        unit = f" in {self.angles}" if self.coordinates != "vectors" else ""
        cosine = "f_r times cos theta of the detector" if self.cosine_weighted else "f_r"
        return (
            f"{self.coordinates} coordinates{unit}, the {self.light} direction toward the "
            f"light; values are {cosine}, 1/sr"
        )


def coerce(name: str, value: Any, where: str) -> Any:
    """Return a raw option in the type of the `Declaration` field `name`."""
    if name not in Declaration.option_names():
        close = difflib.get_close_matches(name, Declaration.option_names(), n=1)
        hint = f" Did you mean {close[0]!r}?" if close else ""
        raise UsageError(
            f"{where}: {name!r} is not a key of a declaration.{hint} "
            f"Allowed: {', '.join(Declaration.option_names())}."
        )
    if name in ("directions", "values", "sigma", "channels"):
        items = value.split(",") if isinstance(value, str) else value
        if not isinstance(items, Sequence):
            items = (items,)
        return tuple(item.strip() if isinstance(item, str) else item for item in items)
    if name == "wavelengths":
        items = value.split(",") if isinstance(value, str) else np.atleast_1d(value)
        try:
            return tuple(float(item) for item in items)
        except (TypeError, ValueError) as error:
            raise UsageError(f"{where}: wavelengths: found {value!r}, not numbers.") from error
    if name == "cosine_weighted":
        return _as_bool(value, f"{where}: {name}")
    return value


def position_of(column: Column, names: Sequence[str], where: str) -> int:
    """Return the 0-based position of a column given by name or 1-based position."""
    if isinstance(column, str):
        if column in names:
            return list(names).index(column)
        folded = [name.strip().lower() for name in names]
        if folded.count(column.strip().lower()) == 1:
            return folded.index(column.strip().lower())
        if not column.strip().isdigit():
            close = difflib.get_close_matches(column, names, n=1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            raise UsageError(
                f"{where}: there is no column {column!r}.{hint} Columns: {', '.join(names)}."
            )
        column = int(column)
    if not isinstance(column, int) or isinstance(column, bool) or not 1 <= column <= len(names):
        raise UsageError(
            f"{where}: column {column!r} was declared, but the columns are 1 to {len(names)}."
        )
    return column - 1


def samples_from(
    declaration: Declaration,
    take: Callable[[Column], FloatArray],
    names: Mapping[Column, str],
    readable: BoolArray,
    rows: IntArray,
    source: Source,
) -> Samples:
    """Return the samples of a declared table.

    Parameters: `take`, gives a column (n,), NaN where missing; `names`, what the value
    columns are called; `readable` (n,), False where the row could not be parsed; `rows`
    (n,), where it stands in the file.
    """
    first, second = _directions(declaration, take, len(rows))
    wi, wo = (first, second) if declaration.light == "first" else (second, first)
    value = np.stack([take(column) for column in declaration.values], axis=1)
    sigma = None
    if declaration.sigma:
        sigma = np.stack([take(column) for column in declaration.sigma], axis=1)
        sigma = np.broadcast_to(sigma, value.shape)
    if declaration.cosine_weighted:
        # below the horizon the cosine says nothing: those rows are flagged, not divided
        cosine = np.where(wo[:, 2] > 0.0, wo[:, 2], 1.0)[:, None]
        value = value / cosine
        sigma = None if sigma is None else sigma / cosine
    flags = np.where(readable, 0, int(Flag.UNREADABLE))
    if declaration.flags is not None:
        mark = take(declaration.flags)
        if names.get(declaration.flags, declaration.flags) == OWN_FLAGS:
            flags |= np.nan_to_num(mark).astype(np.int64)
        else:
            flags |= np.where(np.isfinite(mark) & (mark != 0.0), int(Flag.REJECTED), 0)
    value_names = _channel_names([names.get(column, "") for column in declaration.values])
    wavelengths = declaration.wavelengths or _wavelengths(value_names)
    return Samples(
        wi=wi,
        wo=wo,
        value=value,
        sigma=sigma,
        wavelengths=np.array(wavelengths) if wavelengths else None,
        channels=declaration.channels or (() if wavelengths else value_names),
        flags=flags,
        rows=rows,
        source=replace(source, convention=source.convention or declaration.convention()),
    )


def wavelength_of(name: str) -> float | None:
    """Return the wavelength in nm of a column name: 400nm, "400 nm", 400, w400, or None."""
    text = name.strip().lower().removesuffix("nm").removeprefix("w").strip(" _")
    if "_" in text:  # float() would take 400_5 for 4005
        return None
    try:
        wavelength = float(text)
    except ValueError:
        return None
    return wavelength if 150.0 <= wavelength <= 20000.0 else None


def _channel_names(names: Sequence[str]) -> tuple[str, ...]:
    """Names of the value columns; () where a file has none, R G B however they are spelt."""
    if not all(names):
        return ()
    initials = tuple(name[0].upper() for name in names)
    spelt = all(name.lower() in ("r", "g", "b", "red", "green", "blue") for name in names)
    return initials if spelt and initials == ("R", "G", "B") else tuple(names)


def _wavelengths(names: Sequence[str]) -> tuple[float, ...]:
    found = [wavelength_of(name) for name in names]
    return () if None in found or not found else tuple(w for w in found if w is not None)


def _directions(
    declaration: Declaration, take: Callable[[Column], FloatArray], n: int
) -> tuple[FloatArray, FloatArray]:
    columns = [_column(column, take, n) for column in declaration.directions]
    if declaration.coordinates == "vectors":
        return np.stack(columns[:3], axis=1), np.stack(columns[3:], axis=1)
    if declaration.angles == "degrees":
        columns = [np.deg2rad(column) for column in columns]
    if declaration.coordinates == "half_difference":
        return directions_from_half_diff(columns[0], columns[1], columns[2])
    if declaration.coordinates == "relative":
        theta_i, theta_o, phi = columns
        return directions_from_spherical(theta_i, np.zeros(n)), directions_from_spherical(
            theta_o, phi
        )
    theta_i, phi_i, theta_o, phi_o = columns
    return directions_from_spherical(theta_i, phi_i), directions_from_spherical(theta_o, phi_o)


def _column(column: Column, take: Callable[[Column], FloatArray], n: int) -> FloatArray:
    if isinstance(column, str) and column.startswith("="):
        try:
            return np.full(n, float(column[1:]))
        except ValueError as error:
            raise UsageError(f"directions: {column!r} should be = and a number.") from error
    return take(column)


def _one_of(name: str, value: Any, allowed: Sequence[str]) -> None:
    if value not in allowed:
        known = ", ".join(repr(item) for item in allowed if item)
        raise UsageError(f"{name}: found {value!r} but expected one of {known}.")


def _as_bool(value: Any, where: str) -> bool:
    if isinstance(value, bool):
        return value
    word = str(value).strip().lower()
    if word in _TRUE | _FALSE:
        return word in _TRUE
    raise UsageError(f"{where}: found {value!r} but expected true or false.")
