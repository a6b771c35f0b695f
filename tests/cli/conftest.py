"""Run the program in this process, and a method that needs no population."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

import brdfit.reconstruct
from brdfit.arrays import FloatArray
from brdfit.cli import main
from brdfit.grid import Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct.result import Reconstruction, direct_result
from brdfit.report import fit_figure
from brdfit.samples import Samples


class Ended(NamedTuple):
    """How a run of the program ended."""

    code: int
    out: str
    err: str


Run = Callable[..., Ended]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs the program with words and returns (code, out, err)."""

    def call(*words: object) -> Ended:
        code = main([str(word) for word in words])
        return Ended(code, *capsys.readouterr())

    return call


@dataclass(frozen=True)
class _Constant:
    level: FloatArray

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return np.tile(self.level, (len(wi), 1))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return grid.spread(np.tile(self.level, (grid.cells.size, 1)))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        return None


@dataclass(frozen=True)
class Constant:
    """Takes every material for a Lambertian."""

    name: ClassVar[str] = "constant"

    error_metric: str = "log"
    """How to average: linear or log."""
    careful: bool = True
    """Use the median."""
    passes: int = 1
    """How often to do it."""
    damping: float | None = None
    """Nothing; a number."""

    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        samples.require_usable()
        level = np.nanmedian(np.where(samples.positive, samples.value, np.nan), axis=0)
        estimate = np.tile(np.log(level), (len(samples), 1))
        return direct_result(self, samples, _Constant(level), estimate)


@pytest.fixture
def constant(monkeypatch: pytest.MonkeyPatch) -> type[Constant]:
    """Make `Constant` the only method of the program."""
    monkeypatch.setattr(brdfit.reconstruct, "METHODS", {"constant": Constant})
    return Constant


@pytest.fixture
def paint_csv(tmp_path: Path) -> Path:
    """Return a good CSV of 60 measurements, degrees and RGB named in its header."""
    rng = np.random.default_rng(5)
    lines = ["theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,R,G,B"]
    for theta_i in (10, 30, 60):
        for theta_o in (5, 20, 35, 50, 65):
            for phi in (0, 60, 120, 180):
                value = 0.1 * rng.lognormal(0.0, 0.05, 3)
                lines.append(f"{theta_i},0,{theta_o},{phi}," + ",".join(f"{v:.5f}" for v in value))
    path = tmp_path / "paint.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(autouse=True)
def _small_spheres(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw spheres of few pixels under few lights: the time of a picture goes there."""
    monkeypatch.setattr(fit_figure, "_SPHERE_SIZE", 16)
    monkeypatch.setattr(fit_figure, "_SPACING", 0.5)
