"""Tables and measurements whose faults are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.geometry import directions_from_spherical
from brdfit.grid import Grid
from brdfit.samples import Samples
from brdfit.table import Table

GRID = Grid(30, 30, 36)


@pytest.fixture
def table_of() -> Callable[..., Table]:
    """Return a function that makes a table of any function of direction."""

    def make(brdf, grid: Grid = GRID, valid=None) -> Table:
        cells = brdf.evaluate(*grid.directions(grid.cells))
        values = np.zeros((grid.size, cells.shape[1]))
        values[grid.cells] = cells
        return Table(values=values.reshape(*grid.shape, -1), grid=grid, valid=valid)

    return make


@pytest.fixture
def measured() -> Callable[..., Samples]:
    """Return a function that measures a BRDF at lights of 0 to 75 degrees, all detectors.

    `tilt` turns the sample about the y axis, degrees; `noise` is the deviation of ln f.
    """

    def make(brdf, tilt: float = 0.0, noise: float = 0.0, step: float = 7.5) -> Samples:
        polar = np.radians(np.arange(0.0, 83.0, step))
        light, theta, phi = np.meshgrid(
            polar[polar < np.radians(76.0)], polar, np.radians(np.arange(0.0, 360.0, 15.0))
        )
        wi = directions_from_spherical(light.ravel(), np.zeros(light.size))
        wo = directions_from_spherical(theta.ravel(), phi.ravel())
        keep = (theta.ravel() > 0.0) | (phi.ravel() == 0.0)
        wi, wo = wi[keep], wo[keep]
        angle = np.radians(tilt)
        turn = np.array(
            [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
        )
        value = brdf.evaluate(wi @ turn.T, wo @ turn.T)
        value = value * np.random.default_rng(7).lognormal(0.0, noise, value.shape)
        return Samples(wi=wi, wo=wo, value=value)

    return make
