"""Several sources as one population, each member with a weight."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray, frozen
from brdfit.errors import PopulationError
from brdfit.files import sha256_of_bytes
from brdfit.populations.contract import MemberSource, member_values

__all__ = ["Joined"]


@dataclass(frozen=True, eq=False)
class Joined:
    """A `MemberSource` (and `WeightedSource`) over the members of its parts, in their order.

    Raises `PopulationError` where channels differ, a member has a name twice, or weights are
    not one above zero for each member.
    """

    name: str
    parts: tuple[MemberSource, ...]
    prior_weights: FloatArray
    """What each member counts, (members,), above zero."""

    def __post_init__(self) -> None:
        channels = {part.channels for part in self.parts}
        if len(channels) != 1:
            raise PopulationError(
                f"population {self.name!r}: found {len(self.parts)} parts with {len(channels)} "
                f"lists of channels, but the parts of a population have the same."
            )
        weights = frozen(self.prior_weights, np.float64)
        if (
            weights.shape != (len(self.members),)
            or not (np.isfinite(weights) & (weights > 0)).all()
        ):
            raise PopulationError(
                f"population {self.name!r}: found weights of shape {weights.shape}, the smallest "
                f"{np.min(weights):g}, but each of the {len(self.members)} members has one above "
                f"zero; leave out what shall not count."
            )
        if len(set(self.members)) != len(self.members):
            raise PopulationError(f"population {self.name!r}: two members have the same name.")
        object.__setattr__(self, "prior_weights", weights)

    @property
    def channels(self) -> tuple[str, ...]:
        """Those of the parts."""
        return self.parts[0].channels

    @property
    def bilateral(self) -> bool:
        """True if every part is."""
        return all(part.bilateral for part in self.parts)

    @cached_property
    def members(self) -> tuple[str, ...]:
        """Members of each part, one part after the other."""
        return tuple(member for part in self.parts for member in part.members)

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Material of each member; one that two parts have leaves both together."""
        return tuple(material for part in self.parts for material in part.materials)

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the fingerprints of the parts, in order, and of the weights."""
        facts = [[part.fingerprint for part in self.parts], self.prior_weights.tolist()]
        return sha256_of_bytes(json.dumps(facts).encode())

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), channels), float32, at direction pairs (n, 3)."""
        pick = np.asarray(pick)
        by_channel = np.empty((len(self.channels), len(wi), len(pick)), dtype=np.float32)
        first = 0
        for part in self.parts:
            to = np.flatnonzero((pick >= first) & (pick < first + len(part.members)))
            if to.size:
                values = part.evaluate(wi, wo, pick[to] - first)
                by_channel[:, :, to] = np.moveaxis(values, 2, 0)
            first += len(part.members)
        return member_values(by_channel)
