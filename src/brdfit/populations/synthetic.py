"""Analytic materials of kinds that the measured databases lack, made from recipes.

A member is "mirror/07": the seventh of its family. A family is one material: its members are
siblings, and leave together. Nothing to download, no randomness: the parameters follow from
the recipes (see `recipes`), and the fingerprint from the parameters.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray, IntArray, as_directions
from brdfit.files import sha256_of_bytes
from brdfit.models import Layered, PairAngles
from brdfit.populations.contract import MemberSource, member_values
from brdfit.populations.recipes import BANDS, RECIPES, Draws, Recipe

__all__ = ["Synthetic", "synthetic_materials"]

CHANNELS = ("R", "G", "B")

# Raise it when a change of the models changes values: caches of the old ones then expire.
_VERSION = 1
# Rows of a block whose temporaries (block x columns, float64) stay in the processor's cache.
_BLOCK = 512


@dataclass(frozen=True)
class Synthetic:
    """A `MemberSource` over the members of some recipes."""

    recipes: tuple[Recipe, ...]

    @property
    def name(self) -> str:
        """Always "synthetic"."""
        return "synthetic"

    @property
    def channels(self) -> tuple[str, ...]:
        """R, G, B."""
        return CHANNELS

    @property
    def bilateral(self) -> bool:
        """Every model is symmetric in theta_i and theta_o at given theta_h and theta_d."""
        return True

    @cached_property
    def members(self) -> tuple[str, ...]:
        """Family/number."""
        return tuple(
            f"{recipe.name}/{number:02d}"
            for recipe in self.recipes
            for number in range(1, recipe.members + 1)
        )

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """The family of each member: they leave together."""
        return tuple(recipe.name for recipe in self.recipes for _ in range(recipe.members))

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of every parameter to nine digits, and the version of their evaluation."""
        lines = [f"synthetic {_VERSION}"]
        for recipe, model in zip(self.recipes, self._models, strict=True):
            for part in model.parts:
                lines.append(f"{recipe.name} {type(part).__name__}")
                lines += [" ".join(f"{x:.9g}" for x in values) for values in _figures(part)]
        return sha256_of_bytes("\n".join(lines).encode())

    @cached_property
    def _models(self) -> tuple[Layered, ...]:
        return tuple(recipe.make(Draws(recipe.name, recipe.members)) for recipe in self.recipes)

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), 3), float32, at direction pairs (n, 3); 0 below the horizon."""
        wi, wo = as_directions("wi", wi), as_directions("wo", wo)
        by_channel = np.empty((len(CHANNELS), len(wi), len(pick)), dtype=np.float32)
        groups = self._groups(np.asarray(pick))
        for start in range(0, len(wi), _BLOCK):
            rows = slice(start, start + _BLOCK)
            angles = PairAngles.of(wi[rows], wo[rows])
            for group in groups:
                group.put(angles, by_channel[:, rows])
            if not angles.above.all():
                by_channel[:, rows][:, ~angles.above[:, 0]] = 0.0
        return member_values(by_channel)

    def _groups(self, pick: IntArray) -> list[_Group]:
        """Return the picked members of each family, those without any left out."""
        groups, first = [], 0
        for recipe, model in zip(self.recipes, self._models, strict=True):
            to = np.flatnonzero((pick >= first) & (pick < first + recipe.members))
            if to.size:
                columns = np.arange(len(BANDS))[:, None] * recipe.members + (pick[to] - first)
                groups.append(_Group(to, _columns(model, columns.ravel())))
            first += recipe.members
        return groups


@dataclass(frozen=True, eq=False)
class _Group:
    """Members of one family."""

    to: IntArray
    """Where the members go among those picked."""
    model: Layered
    """A column for each channel and member, the members of a channel together."""

    def put(self, angles: PairAngles, out: FloatArray) -> None:
        """Write the values to the columns `to` of `out` (channels, n, members)."""
        values = self.model.at(angles)
        for channel, into in enumerate(out):
            into[:, self.to] = values[:, channel * self.to.size : (channel + 1) * self.to.size]


def _columns(model: Layered, columns: IntArray) -> Layered:
    """Return the model with some of its columns."""
    return Layered(tuple(type(part)(*(x[columns] for x in _figures(part))) for part in model.parts))


def _figures(part: Any) -> list[FloatArray]:
    """Return the parameters of a part, (columns,) each, in the order of its fields."""
    return [getattr(part, item.name) for item in dataclasses.fields(part)]


@lru_cache(maxsize=1)
def synthetic_materials() -> MemberSource:
    """Return the source of every recipe."""
    return Synthetic(RECIPES)
