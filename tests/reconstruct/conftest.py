"""A population of made-up materials that costs next to nothing, and samples of its members."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest

from brdfit.arrays import FloatArray, IntArray
from brdfit.geometry import directions_from_spherical
from brdfit.models import Ggx
from brdfit.populations import Population
from brdfit.populations.contract import member_values
from brdfit.samples import Samples

MATERIALS = 10


@dataclass(frozen=True)
class ToySource:
    """GGX lobes over Lambertian bases; the last material has two members."""

    name: str = "toy"
    fingerprint: str = "toy of the reconstruct tests, 1"
    channels: tuple[str, ...] = ("R", "G", "B")
    bilateral: bool = True

    @property
    def members(self) -> tuple[str, ...]:
        return (*(f"m{index}" for index in range(MATERIALS)), f"m{MATERIALS - 1}/twin")

    @property
    def materials(self) -> tuple[str, ...]:
        return tuple(member.split("/")[0] for member in self.members)

    @cached_property
    def models(self) -> tuple[Ggx, ...]:
        rng = np.random.default_rng(7)
        count = len(self.members)
        diffuse = rng.uniform(0.02, 0.7, (count, 3))
        f0 = rng.uniform(0.02, 0.3, (count, 1)) * rng.uniform(0.7, 1.0, (count, 3))
        alpha = np.geomspace(0.08, 0.7, count)
        return tuple(Ggx(d, f, a) for d, f, a in zip(diffuse, f0, alpha, strict=True))

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        values = np.stack([self.models[index].evaluate(wi, wo).T for index in pick], axis=-1)
        return member_values(values.astype(np.float32))


@pytest.fixture(scope="session")
def toy() -> Population:
    """Return the toy population: 10 materials, 11 members, RGB."""
    return Population.of(ToySource())


def directions(n: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return n pairs, a third of them near the mirror direction, as people measure."""
    rng = np.random.default_rng(seed)
    theta = np.arccos(rng.uniform(0.05, 1.0, (2, n)))
    phi = rng.uniform(-np.pi, np.pi, (2, n))
    near = rng.random(n) < 0.33
    theta[1, near] = np.clip(theta[0, near] + rng.normal(0.0, 0.1, near.sum()), 0.0, 1.5)
    phi[1, near] = phi[0, near] + np.pi + rng.normal(0.0, 0.1, near.sum())
    wi, wo = directions_from_spherical(theta, phi)
    return wi, wo


@pytest.fixture(scope="session")
def measure(toy: Population) -> Callable[..., Samples]:
    """Return a function that measures a member: `measure("m3", n=200, noise=0.02, seed=1)`.

    With `bands`, at that many wavelengths between 400 and 700 nm instead of RGB.
    """

    def make(
        member: str = "m4", n: int = 150, noise: float = 0.02, seed: int = 1, bands: int = 0
    ) -> Samples:
        wi, wo = directions(n, seed)
        value = toy.subset([member]).evaluate(wi, wo)[:, 0].astype(np.float64)
        wavelengths = None
        if bands:
            wavelengths = np.linspace(400.0, 700.0, bands)
            mix = np.linspace(0.0, 1.0, bands)
            value = value[:, [2]] * (1.0 - mix) + value[:, [0]] * mix
        rng = np.random.default_rng(seed + 1000)
        value = value * np.exp(noise * rng.normal(size=value.shape))
        return Samples(wi=wi, wo=wo, value=value, wavelengths=wavelengths)

    return make
