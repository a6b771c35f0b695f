"""Synthetic families, and several sources as one population with weights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brdfit.arrays import FloatArray
from brdfit.errors import PopulationError
from brdfit.geometry import directions_from_spherical
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations import Population, check, columns, list_populations, population
from brdfit.populations.embedded import SHARES
from brdfit.populations.joined import Joined
from brdfit.populations.recipes import RECIPES, Draws
from brdfit.populations.synthetic import Synthetic

Draw = Callable[[int], tuple[FloatArray, FloatArray]]
Toy = Callable[..., Any]
SMALL = Grid(12, 10, 16)


def test_a_family_is_a_material() -> None:
    synthetic = population("synthetic")
    assert len(synthetic) == sum(recipe.members for recipe in RECIPES)
    assert synthetic.unique_materials == tuple(recipe.name for recipe in RECIPES)
    assert "mirror" not in synthetic.without(["mirror"]).materials


def test_every_member_is_finite_and_above_zero_everywhere(
    random_directions: Draw, rng: np.random.Generator
) -> None:
    synthetic = population("synthetic")
    cells = MERL_GRID.directions(rng.choice(MERL_GRID.cells, 200, replace=False))
    grazing = directions_from_spherical(
        np.pi / 2 - 10.0 ** rng.uniform(-9, -1, (2, 200)), rng.uniform(-np.pi, np.pi, (2, 200))
    )
    up = np.array([[0.0, 0.0, 1.0]])
    for wi, wo in (cells, random_directions(200), (grazing[0], grazing[1]), (up, up)):
        value = synthetic.evaluate(wi, wo)
        assert np.isfinite(value).all()
        assert (value > 0.0).all()


def test_every_member_is_reciprocal_and_symmetric_as_it_says(random_directions: Draw) -> None:
    synthetic = population("synthetic")
    wi, wo = random_directions(200)
    here = synthetic.evaluate(wi, wo)
    np.testing.assert_allclose(synthetic.evaluate(wo, wi), here, rtol=1e-4)
    mirrored = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(synthetic.evaluate(wi * mirrored, wo * mirrored), here, rtol=1e-4)


def test_there_is_nothing_below_the_horizon() -> None:
    wi, wo = np.array([[0.0, 0.0, 1.0]] * 2), np.array([[0.6, 0.0, -0.8], [0.6, 0.0, 0.8]])
    value = population("embedded").evaluate(wi, wo)
    assert not value[0].any()
    assert value[1].all()


def test_some_members_are_the_same_as_those_columns_of_all(random_directions: Draw) -> None:
    wi, wo = random_directions(30)
    everything = population("embedded")
    some = everything.subset(["steel", "mirror/03", "pearl/01", "matte/20"])
    np.testing.assert_array_equal(
        some.evaluate(wi, wo), everything.evaluate(wi, wo)[:, list(some.selected)]
    )


def test_no_two_members_are_alike(random_directions: Draw) -> None:
    logs = population("synthetic").log_values(*random_directions(60))
    members = np.moveaxis(logs, 1, 0).reshape(logs.shape[1], -1)
    apart = np.abs(members[:, None] - members[None]).max(axis=2)
    np.fill_diagonal(apart, np.inf)
    assert apart.min() > 0.1


def test_draws_fill_every_stratum_of_every_dimension_in_another_order() -> None:
    draws = Draws("any", 200)
    shares = np.stack([draws.share() for _ in range(12)])
    np.testing.assert_allclose(
        np.sort(shares, axis=1), np.tile((np.arange(200) + 0.5) / 200, (12, 1))
    )
    assert np.abs(np.corrcoef(shares) - np.eye(12)).max() < 0.3
    assert not np.allclose(Draws("other", 200).share(), shares[0])


FINGERPRINT = "ddf4cb7f4ffab37f"
LEVEL = [-4.09361, -1.73585, -1.9651, -3.42493, -3.32926, -1.6862, -1.93251]


def test_values_change_only_together_with_the_fingerprint() -> None:
    """If this fails on purpose: raise the version in synthetic.py, then write both here."""
    synthetic = population("synthetic")
    wi, wo = MERL_GRID.directions(MERL_GRID.cells[::9973])
    level = synthetic.log_values(wi, wo).mean(axis=(0, 2), dtype=np.float64)
    assert synthetic.fingerprint[:16] == FINGERPRINT
    np.testing.assert_allclose(level[[0, 30, 60, 90, 120, 150, -1]], LEVEL, rtol=1e-5)


def test_the_fingerprint_follows_the_parameters() -> None:
    assert Synthetic(RECIPES[:2]).fingerprint != Synthetic(RECIPES[:1]).fingerprint
    assert Synthetic(RECIPES).fingerprint == population("synthetic").fingerprint


def test_members_of_an_ordinary_source_count_alike(toy: Toy) -> None:
    np.testing.assert_allclose(Population.of(toy()).weights, 1.0 / 3.0)


def test_members_of_networks_count_alike(shared_data: Path) -> None:
    networks = population(shared_data / "nbrdf" / "merl_nbrdf.zip")
    np.testing.assert_allclose(networks.weights, 0.01)


def test_members_of_joined_sources_count_as_they_are_told(toy: Toy) -> None:
    family = Synthetic(RECIPES[:1])
    joined = Joined("both", (toy(), family), np.repeat([2.0, 1.0], [3, len(family.members)]))
    weights = Population.of(joined).weights
    np.testing.assert_allclose(weights[:3], 2.0 * weights[-1])
    assert weights.sum() == pytest.approx(1.0)


def test_the_families_of_embedded_count_as_their_shares_say() -> None:
    embedded = population("embedded")
    kinds = np.array([m if m in SHARES else "published" for m in embedded.materials])
    for kind, share in SHARES.items():
        found = embedded.weights[kinds == kind].sum()
        assert found == pytest.approx(share / sum(SHARES.values()))


def test_weights_of_a_selection_keep_their_proportions() -> None:
    everything = population("embedded")
    some = everything.subset(["steel", "mirror", "cloth/02"])
    expected = everything.weights[list(some.selected)]
    np.testing.assert_allclose(some.weights, expected / expected.sum())


def test_joined_values_are_those_of_the_parts(toy: Toy, random_directions: Draw) -> None:
    wi, wo = random_directions(40)
    family = Synthetic(RECIPES[:1])
    joined = Population.of(Joined("both", (toy(), family), _alike(toy(), family)))
    value = joined.evaluate(wi, wo)
    np.testing.assert_array_equal(value[:, :3], Population.of(toy()).evaluate(wi, wo))
    np.testing.assert_array_equal(value[:, 3:], Population.of(family).evaluate(wi, wo))
    assert all(value[:, :, channel].flags.c_contiguous for channel in range(3))


def test_the_fingerprint_of_joined_sources_follows_parts_and_weights(toy: Toy) -> None:
    family = Synthetic(RECIPES[:1])
    alike = _alike(toy(), family)
    prints = {
        Joined("both", parts, weights).fingerprint
        for parts, weights in (
            ((toy(), family), alike),
            ((toy(), family), alike * np.linspace(1.0, 2.0, alike.size)),
            ((toy(fingerprint="toy-2"), family), alike),
            ((family, toy()), alike),
        )
    }
    assert len(prints) == 4


def _alike(*parts: Any) -> FloatArray:
    return np.ones(sum(len(part.members) for part in parts))


@dataclass(eq=False)
class _OneChannel:
    """Stands in for a source whose channels are others."""

    channels: tuple[str, ...] = ("value",)
    members: tuple[str, ...] = ("grey",)


def test_sources_that_do_not_go_together_are_refused(toy: Toy) -> None:
    with pytest.raises(PopulationError, match="2 lists of channels"):
        Joined("odd", (toy(), _OneChannel()), np.ones(4))  # type: ignore[arg-type]
    with pytest.raises(PopulationError, match="the same name"):
        Joined("twice", (toy(), toy()), np.ones(6))
    with pytest.raises(PopulationError, match="3 members has one above zero"):
        Joined("nothing", (toy(),), np.array([1.0, 0.0, 1.0]))
    with pytest.raises(PopulationError, match=r"shape \(2,\)"):
        Joined("short", (toy(),), np.ones(2))


def test_leaving_out_a_material_of_one_part_keeps_the_others() -> None:
    embedded = population("embedded")
    without = embedded.without(["chrome"])
    assert len(without) == len(embedded) - 2
    assert set(SHARES) - {"published"} <= set(without.materials)


def test_columns_of_joined_sources_are_their_logarithms(cache: Path) -> None:
    some = population("embedded").subset(["steel", "mirror/02", "cloth/05"])
    found = columns(some, SMALL)
    expected = some.log_values(*SMALL.directions(found.cells))
    np.testing.assert_array_equal(found.load(1), expected[:, :, 1])
    index = np.array([5, 400, 3, 5])
    np.testing.assert_array_equal(found.rows(2, index), expected[index, :, 2])


def test_columns_of_joined_sources_are_not_written_twice(cache: Path, toy: Toy) -> None:
    one, other = toy(), toy(name="other", fingerprint="toy-2", alphas=(0.3,))
    columns(Population.of(one), SMALL)
    both = Population.of(Joined("both", (one, other), np.ones(4)))
    one.asked.clear()
    assert columns(both, SMALL).load(0).shape[1] == 4
    assert not one.asked
    assert other.asked


def test_parts_with_other_rows_are_kept_together(cache: Path, toy: Toy) -> None:
    one, other = toy(), toy(bilateral=False, fingerprint="toy-2", alphas=(0.3,))
    found = columns(Population.of(Joined("both", (one, other), np.ones(4))), SMALL)
    expected = found.population.log_values(*SMALL.directions(found.cells))
    np.testing.assert_array_equal(found.cells, SMALL.cells)
    np.testing.assert_array_equal(found.load(0), expected[:, :, 0])


def test_what_comes_along_is_listed_and_in_order(cache: Path) -> None:
    infos = {info.name: info for info in list_populations()}
    for name in ("published", "synthetic", "embedded"):
        assert infos[name].available
        assert check(name).ok
