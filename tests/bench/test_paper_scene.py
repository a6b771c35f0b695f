"""The cells and columns that all cases of the poster's tables share."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.bench.paper.scene import Scene, stratified
from brdfit.bench.paper.settings import PaperSettings
from brdfit.errors import UsageError
from brdfit.grid import Grid
from brdfit.progress import silent

GRID = Grid(18, 15, 20)
SETTINGS = PaperSettings(universe=0.3, image_size=12, grid=GRID, parts=("errors",))


@pytest.fixture(scope="module")
def scene(toy_population):
    return Scene.build(SETTINGS, toy_population, silent)


def test_a_stratified_subset_has_the_asked_size_and_only_cells_above_the_horizon():
    for count in (1, 100, GRID.cells.size):
        chosen = stratified(GRID, count, np.random.default_rng(0))
        assert len(np.unique(chosen)) == count
        assert np.isin(chosen, GRID.cells).all()


def test_a_stratified_subset_covers_every_axis_evenly():
    chosen = stratified(GRID, GRID.cells.size // 4, np.random.default_rng(0))
    for axis in range(3):
        nodes = np.unravel_index(chosen, GRID.shape)[axis]
        every = np.unravel_index(GRID.cells, GRID.shape)[axis]
        share = np.bincount(nodes, minlength=GRID.shape[axis]) / np.bincount(every)
        assert share.min() > 0.1
        assert share.max() < 0.45


def test_data_of_a_smaller_ratio_are_among_those_of_a_larger(scene):
    sizes = [scene.rows(ratio).size for ratio in (0.1, 0.5, 1.0)]
    assert sizes == [round(ratio * scene.universe.size) for ratio in (0.1, 0.5, 1.0)]
    assert np.isin(scene.rows(0.1), scene.rows(0.5)).all()


def test_measurements_are_the_members_values_at_the_cells(scene, toy_population):
    rows = scene.rows(0.5)
    direct = toy_population.evaluate(*GRID.directions(scene.universe[rows]))[:, 2]
    assert np.allclose(scene.values(2, rows), direct, rtol=1e-5)


def test_the_reference_itself_has_no_perceptual_error_and_another_has(scene):
    assert scene.perceptual_error(1, scene.reference(1)) < 1e-6
    assert scene.perceptual_error(1, scene.reference(2)) > 1.0


class OneMember:
    def __init__(self, population, member):
        self.population, self.member = population, member

    def evaluate(self, wi, wo):
        return self.population.evaluate(wi, wo)[:, self.member].astype(np.float64)


def test_the_target_suffices_for_the_picture_of_the_material(scene, toy_population):
    material = OneMember(toy_population, 0)
    whole = scene.view.sphere.shade(material, scene.view.illumination)
    assert np.allclose(scene.view.shade(scene.reference(0)), whole, rtol=1e-4, atol=1e-6)


def test_outliers_depend_on_the_case_and_on_nothing_else(scene, toy_population):
    rows = scene.rows(0.5)
    first = scene.measured(3, rows, 0.5, 0.4)
    again = Scene.build(SETTINGS, toy_population, silent).measured(3, rows, 0.5, 0.4)
    assert np.array_equal(first.values, again.values)
    assert first.mask.sum() == round(0.4 * rows.size)
    other = scene.measured(4, rows, 0.5, 0.4)
    assert not np.array_equal(first.mask, other.mask)


def test_a_material_is_not_among_the_others(scene):
    assert scene.others(3).tolist() == [0, 1, 2, 4, 5, 6]


def test_a_few_materials_are_spread_over_the_population(toy_population):
    few = PaperSettings(materials=3, grid=GRID, parts=("errors",))
    assert Scene.subjects_of(few, toy_population) == [0, 3, 6]
    assert Scene.subjects_of(SETTINGS, toy_population) == list(range(7))


@pytest.mark.parametrize(
    ("settings", "word"),
    [
        ({"outliers": "typo"}, "factor"),
        ({"universe": 0.0}, "universe"),
        ({"data_ratios": (1.2,)}, "data ratios"),
        ({"parts": ("typo",)}, "sensitivity"),
    ],
)
def test_settings_that_mean_nothing_name_what_is_allowed(settings, word):
    with pytest.raises(UsageError, match=word):
        PaperSettings(**settings)
