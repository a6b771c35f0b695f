"""What a population is: materials that a reconstruction may lean on.

A *member* is one function of direction (one published fit of a material, one network, one
table); a *material* is what leave-one-out leaves out: every member of the same material
goes together. `Population` is a selection of members of a `MemberSource`; formats, fits
and networks implement the source, nobody subclasses the population.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import PopulationError
from brdfit.grid import Grid

__all__ = [
    "VALUE_FLOOR",
    "MemberSource",
    "Population",
    "TabulatedSource",
    "WeightedSource",
    "member_values",
    "source_weights",
]

VALUE_FLOOR = 1e-4
"""1/sr. Logarithms of population values are taken of max(f_r, VALUE_FLOOR).

Networks and measured tables contain exact zeros; a lower floor would let cells that hold
no information dominate every sum of squared logarithms. The darkest measured material of
the MERL database stays above it away from grazing.
"""


class MemberSource(Protocol):
    """Where members come from. Immutable; `fingerprint` changes when any value would."""

    @property
    def name(self) -> str:
        """What a user calls it: "published", or the name of a folder or file."""

    @property
    def members(self) -> tuple[str, ...]:
        """Unique names, in a fixed order."""

    @property
    def materials(self) -> tuple[str, ...]:
        """The material of each member, parallel to `members`."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names, ("R", "G", "B") for every population there is."""

    @property
    def fingerprint(self) -> str:
        """SHA-256 over all content that determines the values, and the version of the code."""

    @property
    def bilateral(self) -> bool:
        """True if f(theta_h, theta_d, phi_d) = f(theta_h, theta_d, pi - phi_d) exactly."""

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), channels) >= 0 in 1/sr of those members at (n, 3).

        float32, finite, 0 below the horizon. The array is laid out by channel: each
        `[:, :, channel]` is a C-contiguous (n, len(pick)) array (see `member_values`).
        """


@runtime_checkable
class TabulatedSource(Protocol):
    """What a `MemberSource` offers besides, if reading a member is what costs.

    Columns of such a source are built member by member.
    """

    def cell_values(self, member: int, grid: Grid, cells: IntArray) -> FloatArray:
        """Return f_r (len(cells), channels) of one member at flat cells of a grid."""


@runtime_checkable
class WeightedSource(Protocol):
    """What a `MemberSource` offers besides, if its members are not equally likely."""

    @property
    def prior_weights(self) -> FloatArray:
        """What each member counts in a prior, (members,), above zero, in any unit.

        Part of the fingerprint.
        """


def source_weights(source: MemberSource) -> FloatArray:
    """Return what each member of a source counts, (members,), sum 1; alike if it does not say."""
    given = isinstance(source, WeightedSource)
    weights = source.prior_weights if given else np.ones(len(source.members))  # type: ignore[attr-defined]
    return np.asarray(weights, dtype=np.float64) / np.sum(weights)


def member_values(by_channel: FloatArray) -> FloatArray:
    """Return (channels, n, members) seen as (n, members, channels), without a copy.

    Everything downstream works channel by channel: this keeps a channel in one piece.
    """
    return np.moveaxis(by_channel, 0, 2)


@dataclass(frozen=True)
class Population:
    """Some or all members of a source, in the source's order."""

    source: MemberSource
    selected: tuple[int, ...]
    """Indices into `source.members`, ascending."""

    @classmethod
    def of(cls, source: MemberSource) -> Population:
        """Return the population of all members of `source`."""
        return cls(source, tuple(range(len(source.members))))

    def __len__(self) -> int:
        return len(self.selected)

    def __repr__(self) -> str:
        materials = len(self.unique_materials)
        return f"Population({self.name!r}, {len(self)} members, {materials} materials)"

    @property
    def name(self) -> str:
        """Name of the source."""
        return self.source.name

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names."""
        return self.source.channels

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the source; the selection is recorded beside it."""
        return self.source.fingerprint

    @cached_property
    def pick(self) -> IntArray:
        """`selected` as an array."""
        return np.asarray(self.selected, dtype=np.int64)

    @cached_property
    def members(self) -> tuple[str, ...]:
        """Names of the selected members."""
        return tuple(self.source.members[index] for index in self.selected)

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Material of each selected member."""
        return tuple(self.source.materials[index] for index in self.selected)

    @cached_property
    def unique_materials(self) -> tuple[str, ...]:
        """Materials, each once, in order."""
        return tuple(dict.fromkeys(self.materials))

    @cached_property
    def weights(self) -> FloatArray:
        """What each selected member counts in a prior, (members,), above zero, sum 1.

        All alike, unless the source has an opinion. A method that takes every channel of every
        member for a column gives each column the weight of its member.
        """
        weights = source_weights(self.source)[self.pick]
        return np.asarray(weights / weights.sum())

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, members, channels), float32, >= 0 in 1/sr, at direction pairs (n, 3)."""
        return self.source.evaluate(wi, wo, self.pick)

    def log_values(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return ln max(f_r, VALUE_FLOOR), (n, members, channels)."""
        values = self.evaluate(wi, wo)
        np.maximum(values, VALUE_FLOOR, out=values)
        return np.asarray(np.log(values, out=values))

    def subset(self, names: Sequence[str]) -> Population:
        """Return only the members whose member or material name is in `names`."""
        wanted = self._known(names)
        return self._keep(lambda member, material: member in wanted or material in wanted)

    def without(self, names: Sequence[str]) -> Population:
        """Return all but the members whose member or material name is in `names`."""
        unwanted = self._known(names)
        return self._keep(lambda member, material: not {member, material} & unwanted)

    def _known(self, names: Sequence[str]) -> set[str]:
        wanted = {names} if isinstance(names, str) else set(names)
        unknown = sorted(wanted - set(self.members) - set(self.materials))
        if unknown:
            some = ", ".join(self.unique_materials[:5])
            raise PopulationError(
                f"population {self.name!r} has no material {unknown[0]!r}; it has {some}, ... "
                f"({len(self.unique_materials)} in all)."
            )
        return wanted

    def _keep(self, test: object) -> Population:
        assert callable(test)
        kept = tuple(
            index
            for index, member, material in zip(
                self.selected, self.members, self.materials, strict=True
            )
            if test(member, material)
        )
        if not kept:
            raise PopulationError(f"population {self.name!r}: nothing is left of the selection.")
        return Population(self.source, kept)
