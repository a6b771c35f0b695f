"""What every test may lean on: where the shared data are, and random directions."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_spherical

ROOT = Path(__file__).resolve().parents[1]

# The same examples on every machine, and no deadline: a busy machine is not a defect.
settings.register_profile(
    "brdfit",
    deadline=None,
    derandomize=True,
    max_examples=60,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
settings.load_profile("brdfit")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the shared measurements; skips the test where it is not there."""
    named = os.environ.get("BRDFIT_SHARED_DATA")
    folder = Path(named) if named else ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no shared data at {folder}; set BRDFIT_SHARED_DATA to run this test")
    return folder.resolve()


@pytest.fixture(scope="session", autouse=True)
def _cache_of_the_tests(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep the tests out of the user's own cache folder, and sharing one among them."""
    if "BRDFIT_CACHE" not in os.environ:
        # xdist workers share the parent of their own base folder
        base = tmp_path_factory.getbasetemp()
        shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
        os.environ["BRDFIT_CACHE"] = str(shared / "brdfit-cache")


@pytest.fixture
def rng() -> np.random.Generator:
    """The same random numbers in every test, whatever ran before."""
    return np.random.default_rng(20260101)


@pytest.fixture
def random_directions(rng: np.random.Generator) -> Callable[[int], tuple[FloatArray, FloatArray]]:
    """Return `n` pairs (wi, wo), each uniform over the upper hemisphere."""

    def draw(n: int) -> tuple[FloatArray, FloatArray]:
        cos_theta = rng.uniform(0.02, 1.0, (2, n))
        phi = rng.uniform(-np.pi, np.pi, (2, n))
        w = directions_from_spherical(np.arccos(cos_theta), phi)
        return w[0], w[1]

    return draw
