"""An empty cache folder for each test, and a source small enough to build in no time."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from brdfit.arrays import FloatArray, IntArray
from brdfit.models import Ggx
from brdfit.populations.contract import member_values


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the empty cache folder that the test uses."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("BRDFIT_CACHE", str(folder))
    return folder


@dataclass(eq=False)
class GgxSource:
    """A `MemberSource` of GGX lobes that counts how often it is asked."""

    alphas: tuple[float, ...] = (0.1, 0.2, 0.4)
    fingerprint: str = "toy-1"
    bilateral: bool = True
    asked: list[int] = field(default_factory=list)
    name: str = "toy"
    channels: tuple[str, ...] = ("R", "G", "B")

    @property
    def members(self) -> tuple[str, ...]:
        return tuple(f"alpha {alpha:g}" for alpha in self.alphas)

    @property
    def materials(self) -> tuple[str, ...]:
        return self.members

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        self.asked.append(len(wi))
        models = [Ggx([0.3, 0.2, 1e-5], [0.04, 0.1, 1e-6], self.alphas[index]) for index in pick]
        values = np.stack([model.evaluate(wi, wo).T for model in models], axis=-1)
        return member_values(values.astype(np.float32))


@pytest.fixture
def toy() -> type[GgxSource]:
    """Return the class: `toy()` is a source of three members."""
    return GgxSource
