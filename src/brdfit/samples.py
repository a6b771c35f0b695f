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

from brdfit.arrays import BoolArray, FloatArray, IntArray, as_columns, as_directions, dot, frozen
from brdfit.errors import SampleError, UsageError
from brdfit.geometry import half_diff_from_directions

__all__ = ["Flag", "Samples", "Source", "default_channels"]

_UNIT_TOLERANCE = 1e-3
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


def default_channels(n: int, wavelengths: FloatArray | None = None) -> tuple[str, ...]:
    """Return channel names: wavelengths in nm, else R G B for three, `value` for one."""
    if wavelengths is not None:
        return tuple(f"{wavelength:g}nm" for wavelength in wavelengths)
    if n == 3:
        return ("R", "G", "B")
    if n == 1:
        return ("value",)
    return tuple(f"channel{index}" for index in range(n))


@dataclass(frozen=True, eq=False)
class Samples:
    """n measurements of one material, frozen.

    | name          | shape         | unit and range                                       |
    |---------------|---------------|------------------------------------------------------|
    | `wi`          | (n, 3)        | unit vectors toward the light, normal = +z           |
    | `wo`          | (n, 3)        | unit vectors toward the detector                     |
    | `value`       | (n, channels) | f_r in 1/sr, cosine not included; NaN = missing      |
    | `sigma`       | (n, channels) | standard deviation of `value`, 1/sr, or None         |
    | `wavelengths` | (channels,)   | nm, or None                                          |
    | `channels`    | channels      | names; made up from wavelengths or count if empty    |
    | `flags`       | (n,)          | `Flag` bits; those given are kept, the rest computed |
    | `rows`        | (n,)          | 1-based line or record of the source, or None        |

    Raises `UsageError` where shapes disagree. Values that cannot be used raise nothing:
    they are flagged.
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
            sigma = np.broadcast_to(as_columns("sigma", self.sigma, len(wi)), value.shape)
            put(self, "sigma", frozen(sigma))
        self._name_channels(value.shape[1])
        if self.rows is not None:
            put(self, "rows", frozen(_per_sample("rows", self.rows, len(wi)), np.int64))
        given = 0 if self.flags is None else _per_sample("flags", self.flags, len(wi))
        flags = _flags(wi, wo, value) | np.asarray(given, dtype=np.int64)
        put(self, "flags", frozen(np.asarray(flags, dtype=np.int64)))

    def _name_channels(self, n: int) -> None:
        put = object.__setattr__
        if self.wavelengths is not None:
            wavelengths = np.atleast_1d(np.asarray(self.wavelengths, dtype=np.float64))
            if wavelengths.shape != (n,):
                raise UsageError(
                    f"wavelengths: found shape {wavelengths.shape} but value has {n} channels."
                )
            put(self, "wavelengths", frozen(wavelengths))
        channels = tuple(self.channels) or default_channels(n, self.wavelengths)
        if len(channels) != n:
            raise UsageError(f"channels: found {len(channels)} names but value has {n} channels.")
        put(self, "channels", channels)

    def __len__(self) -> int:
        return len(self.value)

    @property
    def n_channels(self) -> int:
        """Number of channels."""
        return int(self.value.shape[1])

    @cached_property
    def half_diff(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(theta_h, theta_d, phi_d), each (n,), radians, phi_d in [0, 2 pi)."""
        return half_diff_from_directions(self.wi, self.wo)

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
        """Return the same samples with `flag` added where the mask `rows` (n,) is true."""
        mask = _per_sample("rows", rows, len(self)).astype(bool)
        return replace(self, flags=self.bits | np.where(mask, int(flag), 0))

    def subset(self, rows: npt.ArrayLike) -> Samples:
        """Return the samples of an index or mask array, in that order.

        The flag `DUPLICATE` is worked out again among those that remain.
        """
        pick = np.asarray(rows)

        def take(array: npt.NDArray[Any] | None) -> npt.NDArray[Any] | None:
            return None if array is None else array[pick]

        return replace(
            self,
            wi=self.wi[pick],
            wo=self.wo[pick],
            value=self.value[pick],
            sigma=take(self.sigma),
            flags=self.bits[pick] & ~int(Flag.DUPLICATE),
            rows=take(self.rows),
        )

    def select_channels(self, channels: Sequence[int]) -> Samples:
        """Return the samples with only the channels of these indices, in that order."""
        pick = list(channels)
        computed = int(Flag.NOT_FINITE | Flag.CENSORED | Flag.PARTLY_MISSING)
        return replace(
            self,
            value=self.value[:, pick],
            sigma=None if self.sigma is None else self.sigma[:, pick],
            wavelengths=None if self.wavelengths is None else self.wavelengths[pick],
            channels=tuple(self.channels[index] for index in pick),
            flags=self.bits & ~computed,
        )

    def with_value(self, value: npt.ArrayLike) -> Samples:
        """Return the same directions with other values (n, channels)."""
        computed = int(Flag.NOT_FINITE | Flag.CENSORED | Flag.PARTLY_MISSING)
        return replace(
            self,
            value=np.asarray(value, dtype=np.float64).reshape(self.value.shape),
            flags=self.bits & ~computed,
        )

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


def _flags(wi: FloatArray, wo: FloatArray, value: FloatArray) -> IntArray:
    finite_direction = np.isfinite(wi).all(axis=1) & np.isfinite(wo).all(axis=1)
    finite = np.isfinite(value)
    flags = np.zeros(len(value), dtype=np.int64)
    flags[~finite_direction | ~finite.any(axis=1)] |= int(Flag.NOT_FINITE)
    flags[finite.any(axis=1) & ~finite.all(axis=1)] |= int(Flag.PARTLY_MISSING)
    flags[(finite & (np.nan_to_num(value) <= 0.0)).any(axis=1)] |= int(Flag.CENSORED)
    with np.errstate(invalid="ignore"):
        below = (wi[:, 2] <= 0.0) | (wo[:, 2] <= 0.0)
        length = np.stack([np.sqrt(dot(w, w)) for w in (wi, wo)])
        not_unit = (np.abs(length - 1.0) > _UNIT_TOLERANCE).any(axis=0)
    flags[finite_direction & below] |= int(Flag.BELOW_HORIZON)
    flags[finite_direction & not_unit] |= int(Flag.NOT_UNIT)
    flags[_repeats(wi, wo) & finite_direction] |= int(Flag.DUPLICATE)
    return flags


def _repeats(wi: FloatArray, wo: FloatArray) -> BoolArray:
    repeated = np.zeros(len(wi), dtype=bool)
    if len(wi) == 0:
        return repeated
    key = np.rint(np.nan_to_num(np.hstack([wi, wo])) / _SAME_DIRECTION).astype(np.int64)
    _, first = np.unique(key, axis=0, return_index=True)
    repeated[:] = True
    repeated[first] = False
    return repeated
