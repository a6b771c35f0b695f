"""Which materials constants are chosen on, so that the others stay untouched by the choice."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

__all__ = ["EVERY", "tuning_materials", "untouched_materials", "used_materials"]

EVERY = 3
"""Of the materials in alphabetical order the first, and every third after it, are set apart."""


def tuning_materials(names: Iterable[str]) -> list[str]:
    """Return the materials that constants may be chosen on, given all of a population."""
    return sorted(set(names))[::EVERY]


def untouched_materials(names: Iterable[str]) -> list[str]:
    """Return the others: a figure over these owes nothing to the choice of a constant."""
    every = sorted(set(names))
    return sorted(set(every) - set(tuning_materials(every)))


def used_materials(names: Iterable[str], count: int) -> list[str]:
    """Return `count` of the tuning materials, evenly spread; all of them for 0."""
    found = tuning_materials(names)
    if not 0 < count < len(found):
        return found
    return [found[index] for index in np.linspace(0, len(found) - 1, count).round().astype(int)]
