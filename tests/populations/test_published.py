"""The published fits: all of them, everywhere, and the figures they are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import PopulationError
from brdfit.geometry import directions_from_spherical
from brdfit.grid import MERL_GRID
from brdfit.models import Abc, ShiftedGamma
from brdfit.populations import VALUE_FLOOR, population

Draw = Callable[[int], tuple[FloatArray, FloatArray]]


def test_there_are_two_members_of_each_of_100_materials() -> None:
    published = population("published")
    assert len(published) == 200
    assert len(published.unique_materials) == 100
    assert published.subset(["alum-bronze"]).members == (
        "alum-bronze/shifted_gamma",
        "alum-bronze/abc",
    )


def test_leaving_out_a_material_leaves_out_both_its_members() -> None:
    without = population("published").without(["chrome"])
    assert len(without) == 198
    assert "chrome" not in without.materials


def test_a_material_that_does_not_exist_is_named() -> None:
    with pytest.raises(PopulationError, match="'chromium'"):
        population("published").without(["chromium"])


def test_every_member_is_finite_and_above_zero_everywhere(
    random_directions: Draw, rng: np.random.Generator
) -> None:
    published = population("published")
    cells = MERL_GRID.directions(rng.choice(MERL_GRID.cells, 300, replace=False))
    grazing = directions_from_spherical(
        np.pi / 2 - 10.0 ** rng.uniform(-9, -1, (2, 200)), rng.uniform(-np.pi, np.pi, (2, 200))
    )
    up = np.array([[0.0, 0.0, 1.0]])
    for wi, wo in (cells, random_directions(300), (grazing[0], grazing[1]), (up, up)):
        value = published.evaluate(wi, wo)
        assert np.isfinite(value).all()
        assert (value > 0.0).all()


def test_the_members_are_the_published_figures(random_directions: Draw) -> None:
    wi, wo = random_directions(40)
    found = population("published").subset(["gold-paint"]).evaluate(wi, wo)
    shifted_gamma = ShiftedGamma(
        rho_d=0.147708,
        rho_s=0.160592,
        alpha=0.122506,
        p=0.795078,
        f0=9.16095e-12,
        f1=-0.596835,
        kap=5.98176,
        lambda_=2.64832,
        c=9.3111e-08,
        k=24.3593,
        theta0=-0.284195,
    )
    abc = Abc(k_d=0.150463, a=1.010258, b=46.942558, c=1.75667, ior=7.93611)
    expected = np.stack([model.evaluate(wi, wo)[:, 0] for model in (shifted_gamma, abc)], axis=1)
    np.testing.assert_allclose(found[:, :, 0], expected, rtol=1e-6)


LEVEL = [-2.18544, -4.61279, -2.57752, -1.96833, -4.04831, -2.42267]


def test_values_change_only_together_with_the_fingerprint() -> None:
    """If this fails on purpose: raise the version in published.py, then write both here."""
    published = population("published")
    wi, wo = MERL_GRID.directions(MERL_GRID.cells[::9973])
    level = published.log_values(wi, wo).mean(axis=(0, 2), dtype=np.float64)
    assert published.fingerprint[:16] == "4e32631c46a42ce8"
    np.testing.assert_allclose(level[[0, 42, 99, 100, 142, 199]], LEVEL, rtol=1e-5)


def test_some_members_are_the_same_as_those_columns_of_all(random_directions: Draw) -> None:
    wi, wo = random_directions(30)
    everything = population("published")
    some = everything.subset(["steel", "alum-bronze/abc", "pvc/shifted_gamma"])
    np.testing.assert_array_equal(
        some.evaluate(wi, wo), everything.evaluate(wi, wo)[:, list(some.selected)]
    )


def test_one_channel_of_the_values_is_in_one_piece(random_directions: Draw) -> None:
    wi, wo = random_directions(1000)
    value = population("published").evaluate(wi, wo)
    assert value.shape == (1000, 200, 3)
    assert value.dtype == np.float32
    assert all(value[:, :, channel].flags.c_contiguous for channel in range(3))


def test_logarithms_do_not_fall_below_the_floor(random_directions: Draw) -> None:
    wi, wo = random_directions(500)
    logs = population("published").subset(["black-obsidian"]).log_values(wi, wo)
    assert logs.min() == pytest.approx(np.log(VALUE_FLOOR))


def test_there_is_nothing_below_the_horizon() -> None:
    wi, wo = np.array([[0.0, 0.0, 1.0]] * 2), np.array([[0.6, 0.0, -0.8], [0.6, 0.0, 0.8]])
    value = population("published").evaluate(wi, wo)
    assert not value[0].any()
    assert value[1].all()
