"""A server of the tests' own, on 127.0.0.1, with fits that take no time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import brdfit
import brdfit.reconstruct
from brdfit.arrays import FloatArray
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.progress import Progress, silent
from brdfit.reconstruct.result import Reconstruction, direct_result
from brdfit.samples import Samples

pytest.importorskip("starlette", reason="the viewer needs the extra: pip install 'brdfit[viewer]'")

from brdfit.viewer.serve import Server
from brdfit.viewer.workbench import Workbench

from few_materials import few_materials
from viewer_client import Client


@dataclass(frozen=True)
class Lobe:
    """f_r = level + a lobe about the half vector."""

    level: FloatArray

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        theta_h, _, _ = half_diff_from_directions(wi, wo)
        return self.level + 2.0 * np.exp(-((theta_h / 0.15) ** 2))[:, None]

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return grid.spread(self.evaluate(*grid.directions(grid.cells)))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        return np.full((len(wi), self.level.size), 0.05)


@dataclass(frozen=True)
class Quick:
    """Takes the mean of the samples far from the lobe for the level."""

    name: ClassVar[str] = "quick"

    factor: float = 1.0
    """Multiplies the level."""
    careful: bool = True
    """Nothing."""

    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        samples.require_usable()
        far = samples.half_diff[0] > 0.5
        value = np.where(samples.positive & far[:, None], samples.value, np.nan)
        model = Lobe(self.factor * np.nanmean(value, axis=0))
        wi, wo = samples.safe_directions
        progress("fitting", 0, 1)
        progress("fitting", 1, 1)
        return direct_result(self, samples, model, np.log(model.evaluate(wi, wo)))


@dataclass(frozen=True)
class Slow:
    """Never ends, but reports that it goes on."""

    name: ClassVar[str] = "slow"
    begun: ClassVar[threading.Event] = threading.Event()

    def fit(self, samples: Samples, progress: Progress = silent) -> Reconstruction:
        pause = threading.Event()
        while True:
            self.begun.set()
            progress("waiting for ever", 1, 2)
            pause.wait(0.02)


@pytest.fixture(autouse=True)
def _methods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Offer the quick method as the default, and one that never ends."""
    Slow.begun.clear()
    known = brdfit.reconstruct.METHODS
    before = dict(known)
    monkeypatch.setattr(
        "brdfit.viewer.refit.METHODS", {"quick": Quick, "slow": Slow, **before}, raising=True
    )


@pytest.fixture(autouse=True)
def _small_tables(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let fits give small tables, where a test does not ask for `full_tables`."""
    if "full_tables" not in request.fixturenames:
        monkeypatch.setattr("brdfit.report.fitted.MERL_GRID", Grid(30, 30, 36))


@pytest.fixture
def full_tables() -> None:
    """Let fits give tables on the MERL grid."""


def write_lobe(path: Path) -> Path:
    """Write 90 measurements of a lobe, one of them eight times too large; return the path."""
    lines = ["# a lobe", "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,R,G,B"]
    model = Lobe(np.array([0.1, 0.2, 0.3]))
    for theta_i in (10, 30, 50):
        for theta_o in (5, 20, 35, 50, 65):
            for phi in (0, 60, 90, 120, 150, 180):
                angles = np.radians([theta_i, 0, theta_o, phi])
                wi = np.array([[np.sin(angles[0]), 0.0, np.cos(angles[0])]])
                wo = np.array(
                    [
                        [
                            np.sin(angles[2]) * np.cos(angles[3]),
                            np.sin(angles[2]) * np.sin(angles[3]),
                            np.cos(angles[2]),
                        ]
                    ]
                )
                value = model.evaluate(wi, wo)[0] * (8.0 if len(lines) == 86 else 1.0)
                lines.append(f"{theta_i},0,{theta_o},{phi}," + ",".join(f"{v:.6g}" for v in value))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def lobe_csv(tmp_path: Path) -> Path:
    """Return the CSV of `write_lobe`."""
    return write_lobe(tmp_path / "lobe.csv")


@pytest.fixture
def lobe(lobe_csv: Path) -> Reconstruction:
    """Return a finished fit."""
    return Quick().fit(brdfit.read_samples(lobe_csv))


@pytest.fixture(scope="session")
def sure(tmp_path_factory: pytest.TempPathFactory) -> Reconstruction:
    """Return a fit of real uncertainty: `Posterior` on the lobe's measurements."""
    path = write_lobe(tmp_path_factory.mktemp("sure") / "lobe.csv")
    method = brdfit.Posterior(population=few_materials(), residual_size=100)
    return method.fit(brdfit.read_samples(path))


@pytest.fixture
def bench() -> Iterator[Workbench]:
    """Return an empty workbench."""
    with Workbench() as one:
        yield one


@pytest.fixture
def server(bench: Workbench) -> Iterator[Server]:
    """Return a server of `bench` that runs."""
    with Server(bench).running() as one:
        yield one


@pytest.fixture
def ask(server: Server) -> Client:
    """Return a client of `server`."""
    return Client(server)
