from __future__ import annotations

import numpy as np
import pytest

from brdfit.grid import Grid
from brdfit.report.rgb import rgb_table
from brdfit.table import Table

GRID = Grid(4, 5, 6)


def _table(values: np.ndarray, **keywords: object) -> Table:
    return Table(values=np.broadcast_to(values, (*GRID.shape, len(values))), grid=GRID, **keywords)  # type: ignore[arg-type]


def test_three_channels_stay_as_they_are() -> None:
    table = _table(np.array([0.1, 0.2, 0.3]))
    rgb, conversion = rgb_table(table)
    assert rgb is table
    assert conversion.kind == "none"
    assert str(conversion) == ""


def test_channels_in_another_order_are_put_in_order() -> None:
    rgb, conversion = rgb_table(_table(np.array([0.3, 0.2, 0.1]), channels=("B", "G", "R")))
    assert conversion.kind == "order"
    assert rgb.values[rgb.mask][0] == pytest.approx([0.1, 0.2, 0.3])


def test_one_channel_becomes_grey() -> None:
    rgb, conversion = rgb_table(_table(np.array([0.25])))
    assert conversion.kind == "grey"
    assert np.all(rgb.values[rgb.mask] == np.float32(0.25))
    assert rgb.channels == ("R", "G", "B")


def test_white_bands_become_white() -> None:
    bands = np.arange(400.0, 701.0, 10.0)
    rgb, conversion = rgb_table(_table(np.full(31, 1 / np.pi), wavelengths=bands))
    assert conversion.kind == "spectral"
    assert conversion.from_channels == 31
    assert conversion.clipped_cells == 0
    assert rgb.values[rgb.mask] == pytest.approx(1 / np.pi, rel=1e-5)


def test_colours_outside_the_gamut_are_set_to_zero_and_counted() -> None:
    bands = np.arange(400.0, 701.0, 10.0)
    laser = (bands == 510.0).astype(float)
    rgb, conversion = rgb_table(_table(laser, wavelengths=bands))
    assert rgb.values[rgb.mask].min() == 0.0
    assert conversion.clipped_cells == int(rgb.mask.sum())
    assert conversion.clipped_share == 1.0
    assert conversion.most_negative < -0.1
    assert "gamut" in str(conversion)
    assert str(conversion.clipped_cells) in str(conversion)


def test_invalid_cells_stay_invalid() -> None:
    valid = np.ones(GRID.shape, dtype=bool)
    valid[1, 2, 3] = False
    rgb, _ = rgb_table(_table(np.array([0.25]), valid=valid))
    assert not rgb.mask[1, 2, 3]
