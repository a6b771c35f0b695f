"""Materials of the project's own making, as tables and as functions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.albedo import Evaluable
from brdfit.grid import Grid
from brdfit.samples import Source
from brdfit.table import Table

# Fine enough for the narrowest lobe of these tests, and quick.
GRID = Grid(90, 45, 36)

Tabulate = Callable[[Evaluable], Table]


@pytest.fixture(scope="session")
def tabulate() -> Tabulate:
    """Return a function that makes a table of a model."""

    def make(model: Evaluable) -> Table:
        value = np.zeros((GRID.size, model.evaluate(*GRID.directions(GRID.cells[:1])).shape[1]))
        value[GRID.cells] = model.evaluate(*GRID.directions(GRID.cells))
        source = Source(name="made.npz", format="npz", sha256="0" * 64)
        return Table(value.reshape(*GRID.shape, -1), grid=GRID, source=source)

    return make
