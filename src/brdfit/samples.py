"""Measurements: directions, values, what is wrong with each, and where they came from.

Nothing is dropped when measurements enter: a sample that cannot be used stays in its
row, is flagged, and is counted. What a fit leans on is `Samples.usable`.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from brdfit.arrays import (
    UNIT_TOLERANCE,
    BoolArray,
    FloatArray,
    IntArray,
    as_columns,
    as_directions,
    dot,
    frozen,
)
from brdfit.display import Shown
from brdfit.errors import SampleError, UsageError
from brdfit.geometry import half_diff_from_directions

__all__ = ["Flag", "Samples", "Source", "default_channels"]

# Half a milliradian: directions closer than that are one direction to any instrument.
_SAME_DIRECTION = 5e-4


class Flag(enum.IntFlag):
    """What is wrong with a sample (a bit each; 0 = nothing)."""

    NOT_FINITE = 1
    """No channel holds a finite value, or a direction is not finite: not used."""
    BELOW_HORIZON = 2
    """wi or wo is at or below the horizon: not used."""
    NOT_UNIT = 4
    """wi or wo is not a unit vector (off by more than 0.1 %): not used."""
    CENSORED = 8
    """At least one channel is <= 0: at the noise floor. Used as an upper bound there."""
    PARTLY_MISSING = 16
    """Some, not all, channels are not finite; the others are used."""
    DUPLICATE = 32
    """The directions repeat an earlier sample's; used, each as a measurement of its own."""
    UNREADABLE = 64
    """The row was in the file but could not be read as numbers: not used."""
    REJECTED = 128
    """The file or the user marked the sample as wrong: not used."""


_UNUSABLE = Flag.NOT_FINITE | Flag.BELOW_HORIZON | Flag.NOT_UNIT | Flag.UNREADABLE | Flag.REJECTED

# What only a reader or the user can know. Every other flag follows from directions and
# values, and is worked out anew whenever these change, so that the two never disagree.
_STATED = Flag.UNREADABLE | Flag.REJECTED


@dataclass(frozen=True)
class Source:
    """Where measurements or a table came from; travels into every output."""

    name: str = "arrays"
    """File name without folders, or "arrays"."""
    format: str = "arrays"
    """Name of the format's data sheet."""
    sha256: str = ""
    """Hash of the file's bytes; empty for arrays."""
    convention: str = ""
    """The declared or documented convention, in words."""
    notes: tuple[str, ...] = ()
    """What the reader wants the user to know (header lines, guesses made, ...)."""
    metadata: dict[str, str] = field(default_factory=dict, compare=False)
    """Header fields of the file as written."""


def default_channels(n: int, wavelengths: npt.ArrayLike | None = None) -> tuple[str, ...]:
    """Return channel names: wavelengths in nm, else R G B for three, `value` for one."""
    if wavelengths is not None:
        return tuple(f"{wavelength:g}nm" for wavelength in np.atleast_1d(wavelengths))
    if n == 3:
        return ("R", "G", "B")
    if n == 1:
        return ("value",)
    return tuple(f"channel{index}" for index in range(n))


def name_channels(
    owner: str, n: int, channels: Sequence[str], wavelengths: npt.ArrayLike | None
) -> tuple[tuple[str, ...], FloatArray | None]:
    """Return checked (names, frozen wavelengths) for `n` channels of the class `owner`."""
    if wavelengths is not None:
        wavelengths = frozen(np.atleast_1d(wavelengths), np.float64)
        if wavelengths.shape != (n,):
            raise UsageError(
                f"{owner}: found wavelengths of shape {wavelengths.shape} but {n} channels of "
                f"values; give one wavelength in nm for each channel."
            )
    names = tuple(channels) or default_channels(n, wavelengths)
    if len(names) != n:
        raise UsageError(
            f"{owner}: found {len(names)} channel names {names} but {n} channels of values."
        )
    return names, wavelengths


@dataclass(frozen=True, eq=False)
class Samples(Shown):
    """n measurements of one material, frozen.

    | name          | shape         | unit and range                                       |
    |---------------|---------------|------------------------------------------------------|
    | `wi`          | (n, 3)        | unit vectors toward the light, normal = +z           |
    | `wo`          | (n, 3)        | unit vectors toward the detector                     |
    | `value`       | (n, channels) | f_r in 1/sr, cosine not included; NaN = missing      |
    | `sigma`       | (n, channels) | standard deviation of `value`, 1/sr, or None         |
    | `wavelengths` | (channels,)   | nm, or None                                          |
    | `channels`    | channels      | names; made up from wavelengths or count if empty    |
    | `flags`       | (n,)          | `Flag` bits; see below                               |
    | `rows`        | (n,)          | 1-based line or record of the source, or None        |

    Raises `UsageError` where shapes disagree. Values that cannot be used raise nothing:
    they are flagged. Of the flags given, UNREADABLE and REJECTED are kept; all others are
    worked out from directions and values. A value known only to lie under a detection limit
    is entered as 0, which makes it censored.
    """

    wi: FloatArray
    wo: FloatArray
    value: FloatArray
    sigma: FloatArray | None = None
    wavelengths: FloatArray | None = None
    channels: tuple[str, ...] = ()
    flags: IntArray | None = None
    rows: IntArray | None = None
    source: Source = Source()

    def __post_init__(self) -> None:
        wi, wo = as_directions("wi", self.wi), as_directions("wo", self.wo)
        if len(wi) != len(wo):
            raise UsageError(f"wi has {len(wi)} rows but wo has {len(wo)}: they must pair up.")
        value = as_columns("value", self.value, len(wi))
        put = object.__setattr__
        put(self, "wi", frozen(wi))
        put(self, "wo", frozen(wo))
        put(self, "value", frozen(value))
        if self.sigma is not None:
            put(self, "sigma", frozen(_like_value("sigma", self.sigma, value.shape)))
        names, wavelengths = name_channels(
            "Samples", value.shape[1], self.channels, self.wavelengths
        )
        put(self, "channels", names)
        put(self, "wavelengths", wavelengths)
        if self.rows is not None:
            put(self, "rows", frozen(_per_sample("rows", self.rows, len(wi)), np.int64))
        flags = _flags(wi, wo, value)
        if self.flags is not None:
            flags |= _per_sample("flags", self.flags, len(wi)).astype(np.int64) & int(_STATED)
        put(self, "flags", frozen(flags))

    def __len__(self) -> int:
        return len(self.value)

    @property
    def n_channels(self) -> int:
        """Number of channels."""
        return int(self.value.shape[1])

    @cached_property
    def half_diff(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(theta_h, theta_d, phi_d), each (n,), radians, phi_d in [0, 2 pi)."""
        with np.errstate(invalid="ignore"):  # an infinite direction is flagged, and stays NaN
            theta_h, theta_d, phi_d = half_diff_from_directions(self.wi, self.wo)
        return frozen(theta_h), frozen(theta_d), frozen(phi_d)

    @cached_property
    def bits(self) -> IntArray:
        """`flags` (n,), never None."""
        assert self.flags is not None
        return self.flags

    @cached_property
    def usable(self) -> BoolArray:
        """(n, channels): finite values at directions where a BRDF is defined.

        Censored values are usable, as an upper bound: see `censored`.
        """
        row = (self.bits & int(_UNUSABLE)) == 0
        return frozen(row[:, None] & np.isfinite(self.value))

    @cached_property
    def censored(self) -> BoolArray:
        """(n, channels): usable, but zero or negative: at or under the noise floor."""
        return frozen(self.usable & ~(self.value > 0.0))

    @cached_property
    def positive(self) -> BoolArray:
        """(n, channels): usable and above zero."""
        return frozen(self.usable & (self.value > 0.0))

    @property
    def safe_directions(self) -> tuple[FloatArray, FloatArray]:
        """(wi, wo) with unusable rows at the normal, so that any function can be evaluated.

        Values there mean nothing and must be masked by `usable`.
        """
        row = np.asarray(self.usable.any(axis=1))[:, None]
        normal = np.array([0.0, 0.0, 1.0])
        return np.where(row, self.wi, normal), np.where(row, self.wo, normal)

    @cached_property
    def noise_floor(self) -> FloatArray:
        """(channels,) the value that a censored measurement is known not to exceed, 1/sr.

        The 1st percentile of the channel's positive values: what the instrument could
        still tell from nothing. NaN where a channel has no positive value.
        """
        floor = np.full(self.n_channels, np.nan)
        for channel in range(self.n_channels):
            column = self.value[self.positive[:, channel], channel]
            if column.size:
                floor[channel] = np.percentile(column, 1.0)
        return frozen(floor)

    def flag_counts(self) -> dict[str, int]:
        """Return how many samples carry each flag, names in lower case, zeros left out."""
        counts = {flag.name: int(np.count_nonzero(self.bits & flag)) for flag in Flag}
        return {str(name).lower(): count for name, count in counts.items() if count}

    def with_flags(self, rows: npt.ArrayLike, flag: Flag) -> Samples:
        """Return the same samples with `flag` added where the mask `rows` (n,) is true.

        Raises `UsageError` for a flag that is worked out from the values: to add it would
        say of a measurement what its numbers do not.
        """
        if Flag(flag) & ~_STATED:
            raise UsageError(
                f"with_flags: found {Flag(flag)!r} but only UNREADABLE and REJECTED can be "
                f"stated; the others follow from directions and values (use with_value)."
            )
        mask = _per_sample("rows", rows, len(self)).astype(bool)
        return replace(self, flags=self.bits | np.where(mask, int(flag), 0))

    def subset(self, rows: npt.ArrayLike) -> Samples:
        """Return the samples of an index or mask array, in that order.

        The flag `DUPLICATE` is worked out again among those that remain.
        """
        pick = np.asarray(rows)
        if pick.size == 0:  # an empty list is an array of floats to numpy
            pick = np.zeros(0, dtype=np.int64)
        elif pick.dtype == bool:
            pick = np.flatnonzero(_per_sample("rows", pick, len(self)))

        def take(array: npt.NDArray[Any] | None) -> npt.NDArray[Any] | None:
            return None if array is None else array[pick]

        return replace(
            self,
            wi=self.wi[pick],
            wo=self.wo[pick],
            value=self.value[pick],
            sigma=take(self.sigma),
            flags=self.bits[pick],
            rows=take(self.rows),
        )

    def select_channels(self, channels: Sequence[int]) -> Samples:
        """Return the samples with only the channels of these indices, in that order."""
        pick = list(channels)
        return replace(
            self,
            value=self.value[:, pick],
            sigma=None if self.sigma is None else self.sigma[:, pick],
            wavelengths=None if self.wavelengths is None else self.wavelengths[pick],
            channels=tuple(self.channels[index] for index in pick),
        )

    def with_value(self, value: npt.ArrayLike) -> Samples:
        """Return the same samples with other values (n, channels), 1/sr; `sigma` stays."""
        return replace(self, value=_like_value("value", value, self.value.shape))

    def require_usable(self, at_least: int = 1) -> None:
        """Raise `SampleError` unless that many samples have a positive usable channel."""
        found = int(np.count_nonzero(self.positive.any(axis=1)))
        if found < at_least:
            counts = ", ".join(f"{count} {name}" for name, count in self.flag_counts().items())
            raise SampleError(
                f"{self.source.name}: found {found} usable samples of {len(self)} "
                f"({counts or 'none flagged'}) but at least {at_least} with a positive value "
                f"above the horizon are needed. Check the declared columns and units."
            )


def _per_sample(name: str, value: npt.ArrayLike, n: int) -> npt.NDArray[Any]:
    array = np.asarray(value)
    if array.shape != (n,):
        raise UsageError(f"{name}: found shape {array.shape} but there are {n} samples.")
    return array


def _like_value(name: str, given: npt.ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    array = as_columns(name, given, shape[0])
    if array.shape[1] not in (1, shape[1]):
        raise UsageError(
            f"{name}: found {array.shape[1]} channels but the values have {shape[1]}; give one "
            f"column for all or one for each."
        )
    return np.asarray(np.broadcast_to(array, shape))


def _flags(wi: FloatArray, wo: FloatArray, value: FloatArray) -> IntArray:
    finite_direction = np.isfinite(wi).all(axis=1) & np.isfinite(wo).all(axis=1)
    finite = np.isfinite(value)
    some, every = finite.any(axis=1), finite.all(axis=1)
    below = (wi[:, 2] <= 0.0) | (wo[:, 2] <= 0.0)
    with np.errstate(invalid="ignore", over="ignore"):
        dark = (finite & (value <= 0.0)).any(axis=1)
        length = np.stack([np.sqrt(dot(w, w)) for w in (wi, wo)])
    unit = (np.abs(length - 1.0) <= UNIT_TOLERANCE).all(axis=0)
    duplicate = np.zeros(len(value), dtype=bool)
    duplicate[unit] = _repeats(wi[unit], wo[unit])
    flags = np.zeros(len(value), dtype=np.int64)
    for flag, found in (
        (Flag.NOT_FINITE, ~(finite_direction & some)),
        (Flag.PARTLY_MISSING, some & ~every),
        (Flag.CENSORED, dark),
        (Flag.BELOW_HORIZON, finite_direction & below),
        (Flag.NOT_UNIT, finite_direction & ~unit),
        (Flag.DUPLICATE, duplicate),
    ):
        flags |= np.where(found, int(flag), 0)
    return flags


def _repeats(wi: FloatArray, wo: FloatArray) -> BoolArray:
    """Return (n,) True where a pair of unit vectors repeats an earlier one."""
    # A complex number sorts by its real, then its imaginary part: one exact key a pair.
    _, first = np.unique(_packed(wi) + 1j * _packed(wo), return_index=True)
    repeated = np.ones(len(wi), dtype=bool)
    repeated[first] = False
    return repeated


def _packed(w: FloatArray) -> FloatArray:
    # Unit vectors have components within +-2002 steps: three fit a float64 without rounding.
    steps = np.rint(w / _SAME_DIRECTION)
    return np.asarray((steps[:, 0] * 8192.0 + steps[:, 1]) * 8192.0 + steps[:, 2])
