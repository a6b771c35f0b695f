from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.uncertainty import Uncertainty

Fit = Callable[..., Reconstruction]
Draw = Callable[[int], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class Unsure:
    """Known everywhere, less surely away from the peak; `spread` tells channels apart."""

    spread: tuple[float, ...] = (1.0, 1.0, 1.0)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return np.ones((len(wi), len(self.spread)))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return grid.spread(np.ones((grid.cells.size, len(self.spread))))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        theta_h, _, _ = half_diff_from_directions(wi, wo)
        return (0.1 + 0.2 * theta_h)[:, None] * np.array(self.spread)


def test_a_method_that_states_none_has_none(fit_known: Fit) -> None:
    assert Uncertainty.of(fit_known()) is None


def test_what_travels_in_the_record_is_what_the_method_states(
    fit_known: Fit, random_directions: Draw
) -> None:
    model = Unsure((1.0, 1.5, 2.0))
    stated = Uncertainty.of(replace(fit_known(), model=model))
    assert stated is not None
    again = Uncertainty.from_record(json.loads(json.dumps(stated.record())), "out.json")
    wi, wo = random_directions(500)
    expected = model.stddev(wi, wo)
    assert again.stddev.channels == ("R", "G", "B")
    assert again.evaluate(wi, wo) == pytest.approx(expected, rel=0.03)


def test_channels_that_are_alike_travel_once(fit_known: Fit) -> None:
    stated = Uncertainty.of(replace(fit_known(), model=Unsure()))
    assert stated is not None
    assert stated.stddev.channels == ("all",)
    assert stated.record()["shape"][-1] == 1
    assert len(json.dumps(stated.record())) < 40_000


@pytest.mark.parametrize(
    "damage",
    [
        {"values": "not base64!"},
        {"values": "AAAA"},
        {"shape": [2, 2]},
        {"shape": "x"},
        {"channels": ["a", "b"]},
    ],
)
def test_a_damaged_record_is_refused_by_name(fit_known: Fit, damage: dict[str, object]) -> None:
    stated = Uncertainty.of(replace(fit_known(), model=Unsure()))
    assert stated is not None
    with pytest.raises(CorruptFile, match=r"out\.json: 'uncertainty' is damaged"):
        Uncertainty.from_record({**stated.record(), **damage}, "out.json")
