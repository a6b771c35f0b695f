"""What items there are, and some of them read: the contract of an input."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.reconstruct.compact import Block

__all__ = ["BatchInput", "Part"]


class BatchInput(Protocol):
    """A fixed sequence of items; travels to the processes that do the work, so it is small."""

    @property
    def name(self) -> str:
        """File or folder name, for messages and records."""

    @property
    def count(self) -> int:
        """Number of items."""

    @property
    def samples_per_item(self) -> float:
        """Samples of an item, about: what a block of items is measured by."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names that all items have."""

    @property
    def wavelengths(self) -> tuple[float, ...]:
        """nm, one for each channel, or none."""

    @property
    def longest_name(self) -> int:
        """Bytes of the longest item name in UTF-8."""

    @property
    def positioned(self) -> bool:
        """Whether items have pixel positions."""

    def fingerprint(self) -> str:
        """SHA-256 over all content and all that says how it is read."""

    def part(self, start: int, stop: int) -> Part:
        """Read the items from `start` to `stop`.

        What is wrong with one item is its own; only what spoils all of them raises.
        """


@dataclass(frozen=True, eq=False)
class Part:
    """Some items as read."""

    names: list[str]
    block: Block | None
    """The items that could be read, in order; None where there is none."""
    where: list[int]
    """Which of `names` they are."""
    problems: dict[int, str] = field(default_factory=dict)
    """Of those that could not: why."""
    position: FloatArray | None = None
    """(items, 2) pixel column and row, where the input has them."""

    def __len__(self) -> int:
        return len(self.names)

    def positions(self) -> FloatArray:
        """Return `position`, NaN where the input has none."""
        return np.full((len(self), 2), np.nan) if self.position is None else self.position
