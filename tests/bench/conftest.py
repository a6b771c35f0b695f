"""A small population of made-up materials, for the tests of the benchmarks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from brdfit.geometry import half_diff_from_directions
from brdfit.populations import Population
from brdfit.populations.contract import member_values


@dataclass(frozen=True)
class ToySource:
    """Lambert plus a lobe in theta_h; albedo, gloss and width differ by member."""

    count: int = 7
    name: str = "toy"
    bilateral: bool = True
    channels: tuple[str, ...] = ("R", "G", "B")
    fingerprint: str = "0" * 64

    @property
    def members(self):
        return tuple(f"toy{index:02d}" for index in range(self.count))

    @property
    def materials(self):
        return self.members

    def evaluate(self, wi, wo, pick):
        theta_h, theta_d, _ = half_diff_from_directions(wi, wo)
        rng = np.random.default_rng(3)
        albedo = rng.uniform(0.05, 0.6, (self.count, 3))
        gloss = rng.uniform(0.2, 3.0, self.count)
        width = rng.uniform(0.1, 0.5, self.count)
        lobe = gloss * np.exp(-((theta_h[:, None] / width) ** 2)) * (1 + theta_d[:, None] ** 2)
        above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
        values = (albedo.T[:, None, :] / np.pi + lobe) * above[:, None]
        return member_values(values[:, :, np.asarray(pick)].astype(np.float32))


@pytest.fixture(scope="session")
def toy_population():
    """Seven materials in RGB."""
    return Population.of(ToySource())
