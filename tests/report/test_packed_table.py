"""A table on its way into a browser."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.grid import MERL_GRID, Grid
from brdfit.reconstruct import Reconstruction
from brdfit.report.packed_table import PackedTable
from brdfit.table import Table

SMALL = Grid(12, 10, 16)


def test_what_is_unpacked_is_the_table_to_half_precision(
    fit_known: Callable[..., Reconstruction],
) -> None:
    table = fit_known().table(SMALL)
    packed = PackedTable.of(table)
    assert packed.shape == SMALL.shape
    error = np.abs(packed.unpack() / np.where(table.mask[..., None], table.values, 1.0) - 1.0)
    assert error[table.mask].max() < 2.0**-11 * 1.01


def test_a_full_table_travels_in_less_than_12_mb_however_noisy(
    fit_known: Callable[..., Reconstruction], rng: np.random.Generator
) -> None:
    values = np.array(fit_known().table(MERL_GRID).values)
    noisy = values * np.exp(0.3 * rng.standard_normal(values.shape)).astype(np.float32)
    assert len(PackedTable.of(Table(values=noisy)).content) < 12e6
    assert len(PackedTable.of(Table(values=values)).content) < 2e6


def test_values_beyond_half_floats_are_scaled_not_clipped() -> None:
    values = np.full((*SMALL.shape, 3), 2.0, dtype=np.float32)
    values[0] = 1e6
    packed = PackedTable.of(Table(values=values, grid=SMALL))
    assert packed.scale > 1.0
    np.testing.assert_allclose(packed.unpack()[0, :5], 1e6, rtol=1e-3)
    np.testing.assert_allclose(packed.unpack()[3, 0], 2.0, rtol=1e-3)


def test_a_cell_that_holds_nothing_takes_the_value_of_a_neighbour(
    rng: np.random.Generator,
) -> None:
    values = rng.uniform(0.5, 1.5, (*SMALL.shape, 3)).astype(np.float32)
    valid = np.ones(SMALL.shape, dtype=bool)
    valid[4, 3:6, 2] = False
    values[4, 3:6, 2] = 1e4
    valid[5] = False
    seen = PackedTable.of(Table(values=values, grid=SMALL, valid=valid)).unpack()
    assert seen.max() < 2.0
    np.testing.assert_allclose(seen[4, 4, 2], values[4, 2, 2], rtol=1e-3)
    np.testing.assert_allclose(seen[5, 1], values[4, 1], rtol=1e-3)


def test_bands_and_an_empty_table_are_refused() -> None:
    with pytest.raises(UsageError, match="found 5 channels"):
        PackedTable.of(Table(values=np.ones((*SMALL.shape, 5)), grid=SMALL))
    nothing = np.zeros(SMALL.shape, dtype=bool)
    with pytest.raises(UsageError, match="no valid cell"):
        PackedTable.of(Table(values=np.ones((*SMALL.shape, 3)), grid=SMALL, valid=nothing))
