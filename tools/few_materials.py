"""A population of eight made-up materials that costs next to nothing: for the tests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.models import Ggx
from brdfit.populations import Population
from brdfit.populations.contract import member_values

__all__ = ["few_materials"]

_COUNT = 8


@dataclass(frozen=True)
class _Lobes:
    """GGX lobes over Lambertian bases."""

    name: str = "few"
    fingerprint: str = "few materials of the tests, 1"
    channels: tuple[str, ...] = ("R", "G", "B")
    bilateral: bool = True

    @property
    def members(self) -> tuple[str, ...]:
        return tuple(f"lobe{index}" for index in range(_COUNT))

    materials = members

    @cached_property
    def models(self) -> tuple[Ggx, ...]:
        rng = np.random.default_rng(11)
        diffuse = rng.uniform(0.05, 0.6, (_COUNT, 3))
        return tuple(
            Ggx(base, np.full(3, 0.05), alpha)
            for base, alpha in zip(diffuse, np.geomspace(0.1, 0.6, _COUNT), strict=True)
        )

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        values = np.stack([self.models[index].evaluate(wi, wo).T for index in pick], axis=-1)
        return member_values(values.astype(np.float32))


def few_materials() -> Population:
    """Return the population: eight materials of one member each, RGB."""
    return Population.of(_Lobes())
