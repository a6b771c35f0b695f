"""What a fit supplies reflects no more than arrives, and what was measured stays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from brdfit.albedo import directional_albedo
from brdfit.errors import UsageError
from brdfit.formats import read_samples
from brdfit.geometry import directions_from_spherical
from brdfit.grid import Grid
from brdfit.reconstruct import LocalBasis, Posterior
from brdfit.reconstruct.outcome import Outcome
from brdfit.reconstruct.result import Reconstruction
from brdfit.reconstruct.trust import Trust
from brdfit.samples import Samples

GRID = Grid(24, 24, 24)
BETWEEN = np.radians([0.0, 13.7, 44.4, 61.3, 80.2, 88.7])


@dataclass(frozen=True)
class Runaway:
    """Lambertian of `albedo`, and up to `growth` brighter from 60 to 75 degrees and beyond."""

    albedo: tuple[float, ...] = (0.5, 0.9)
    growth: float = 0.6
    doubt: float | None = None
    """Deviation of ln f_r at grazing light; a tenth of it elsewhere."""

    def _beyond(self, wi, wo):
        return np.clip((0.5 - np.minimum(wi[:, 2], wo[:, 2])) / 0.24, 0.0, 1.0)

    def evaluate(self, wi, wo):
        f = np.array(self.albedo) / np.pi
        return f * (1.0 + self.growth * self._beyond(wi, wo)[:, None])

    def dense(self, grid, progress):
        return grid.spread(self.evaluate(*grid.directions(grid.cells)))

    def stddev(self, wi, wo):
        if self.doubt is None:
            return None
        very = np.minimum(wi[:, 2], wo[:, 2]) < 0.26
        return np.where(very, self.doubt, 0.1 * self.doubt)[:, None] * np.ones(len(self.albedo))


@dataclass(frozen=True)
class Told:
    name: ClassVar[str] = "told"


def measured_to(degrees: float, model: Runaway) -> Reconstruction:
    """Return a fit of measurements that are dense up to an angle of `degrees`."""
    angles = np.radians(np.arange(0.0, degrees + 0.1, 6.0))
    theta_i, theta_o, phi = (
        axis.ravel() for axis in np.meshgrid(angles, angles, np.radians(np.arange(0, 181, 12)))
    )
    wi = directions_from_spherical(theta_i, np.zeros_like(theta_i))
    wo = directions_from_spherical(theta_o, phi)
    samples = Samples(wi=wi, wo=wo, value=model.evaluate(wi, wo))
    nothing = np.zeros(samples.value.shape)
    return Reconstruction(
        samples=samples,
        method=Told(),
        model=model,
        channel_weights=nothing + 1.0,
        residuals=nothing,
        initial_residuals=nothing,
        outliers=np.zeros(len(samples), dtype=bool),
        outlier_rule="none",
        outcome=Outcome.DIRECT,
    )


@pytest.fixture(params=[None, 0.4], ids=["by distance", "by stated doubt"])
def runaway(request) -> Reconstruction:
    """Return a fit that is measured up to 54 degrees and exceeds 1 beyond."""
    return measured_to(54.0, Runaway(doubt=request.param))


def test_the_albedo_of_a_result_is_that_of_its_function(runaway):
    found = runaway.albedo(np.radians([0.0, 80.0]))
    assert found[1] == pytest.approx([0.5 * 1.6, 0.9 * 1.6], rel=1e-3)
    assert 0.5 < found[0, 0] < 0.5 * 1.15
    with pytest.raises(UsageError, match="theta_i"):
        runaway.albedo([2.0])


def test_afterwards_no_incidence_reflects_more_than_arrives(runaway):
    limited = runaway.limited_table(GRID)
    assert directional_albedo(runaway.table(GRID), BETWEEN).max() > 1.4
    assert limited.reached
    # between the nodes of a grid as coarse as this, 3.75 degrees apart
    assert directional_albedo(limited.table, BETWEEN).max() < 1.0 + 2e-3


def test_measured_cells_are_not_moved_by_a_bit(runaway):
    limited = runaway.limited_table(GRID)
    before, after = runaway.table(GRID).values, limited.table.values
    measured = limited.classes == Trust.MEASURED
    assert measured.sum() > 500
    assert np.array_equal(before[measured], after[measured])
    assert not limited.lowered[measured].any()
    assert limited.record()["cells_lowered"]["measured"] == 0
    assert limited.lowered.sum() > 500


def test_a_channel_that_could_exist_keeps_every_value(runaway):
    limited = runaway.limited_table(GRID)
    assert np.array_equal(limited.table.values[..., 0], runaway.table(GRID).values[..., 0])


def test_reciprocity_and_positivity_stay_and_nothing_is_raised(runaway, random_directions):
    table, limited = runaway.table(GRID), runaway.limited_table(GRID).table
    wi, wo = random_directions(500)
    there, back = limited.evaluate(wi, wo), limited.evaluate(wo, wi)
    np.testing.assert_allclose(there, back, rtol=1e-6)
    assert (limited.values[limited.mask] > 0.0).all()
    assert (limited.values <= table.values).all()


def test_a_table_below_one_stays_as_it_is_to_the_bit():
    result = measured_to(54.0, Runaway(albedo=(0.3, 0.6)))
    limited = result.limited_table(GRID)
    assert np.array_equal(limited.table.values, result.table(GRID).values)
    assert limited.table.source == result.table(GRID).source
    assert limited.reached
    assert limited.record()["smallest_factor"] == 1.0
    assert "no incidence reflects more than 1" in limited.sentence


def test_the_least_certain_cells_give_way_first():
    result = measured_to(54.0, Runaway(albedo=(0.8,), growth=0.3, doubt=0.4))
    limited = result.limited_table(GRID)
    left = limited.table.values[..., 0] / np.maximum(result.table(GRID).values[..., 0], 1e-30)
    wi, wo = GRID.directions(GRID.cells)
    lowest = np.minimum(wi[:, 2], wo[:, 2])
    classes = limited.classes.reshape(-1)[GRID.cells]
    left = left.reshape(-1)[GRID.cells]
    unsure = (lowest < 0.26) & (classes == Trust.SUPPLIED)
    surer = (lowest > 0.3) & (lowest < 0.5) & (classes == Trust.SUPPLIED)
    assert min(unsure.sum(), surer.sum()) > 100
    assert left[unsure].mean() < left[surer].mean() - 0.05


@pytest.mark.parametrize("doubt", [None, 0.4])
def test_what_measured_cells_leave_above_one_is_said_and_counted(doubt):
    result = measured_to(84.0, Runaway(albedo=(1.3,), growth=0.0, doubt=doubt))
    limited = result.limited_table(GRID)
    measured = limited.classes == Trust.MEASURED
    assert np.array_equal(limited.table.values[measured], result.table(GRID).values[measured])
    assert not limited.reached
    record = limited.record()
    assert record["incidences_above_after"] > 0
    assert record["largest_after"] > 1.1
    assert record["largest_of_measured_cells_alone"] > 1.0
    assert "measured cells are not moved" in limited.sentence
    assert any("measured cells are not moved" in note for note in limited.table.source.notes)


@pytest.mark.parametrize("growth", [20.0, 200.0])
def test_what_runs_away_a_hundredfold_is_held_too(growth):
    result = measured_to(54.0, Runaway(albedo=(0.3,), growth=growth))
    limited = result.limited_table(GRID)
    measured = limited.classes == Trust.MEASURED
    assert limited.energy.before.max() > 0.2 * growth
    assert limited.reached
    assert np.array_equal(limited.table.values[measured], result.table(GRID).values[measured])
    assert (limited.table.values[limited.table.mask] > 0.0).all()


def test_another_limit_is_kept_and_one_that_cannot_be_is_refused(runaway):
    limited = runaway.limited_table(GRID, albedo=1.2)
    assert 1.1 < directional_albedo(limited.table, BETWEEN).max() < 1.2 + 2e-3
    with pytest.raises(UsageError, match="limit"):
        runaway.limited_table(GRID, albedo=0.0)


def test_what_a_sample_that_is_not_believed_says_may_be_lowered(runaway):
    nobody = replace(runaway, outliers=np.ones(len(runaway.samples), dtype=bool))
    limited = nobody.limited_table(GRID)
    assert not (limited.classes == Trust.MEASURED).any()
    assert limited.reached


def test_a_fit_that_knows_its_prior_is_limited_where_its_own_classes_allow(toy, measure):
    samples = measure(n=300)
    part = samples.subset(np.maximum(*np.arccos([samples.wi[:, 2], samples.wo[:, 2]])) < 0.9)
    brighter = part.with_value(part.value * 1.25)
    result = Posterior(population=toy.without(["m4"]), residual_size=200).fit(brighter)
    grid = Grid(20, 20, 16)
    limit = float(result.albedo(np.radians([80.0])).max()) * 0.95
    limited = result.limited_table(grid, albedo=limit)
    own = result.trust_map.on_grid(grid)
    measured = limited.classes == Trust.MEASURED
    # the doubt is interpolated between coarse nodes: classes may differ at their borders
    assert np.mean((own == limited.classes)[grid.above_horizon]) > 0.95
    assert np.array_equal(limited.table.values[measured], result.table(grid).values[measured])
    assert limited.lowered.any()


def test_paper_beyond_its_last_measured_incidence(shared_data):
    with pytest.warns(match="cannot be used"):
        samples = read_samples(shared_data / "rgl" / "paper_white_rgb.bsdf")
    few = np.sort(np.random.default_rng(0).choice(len(samples), 400, replace=False))
    result = LocalBasis().fit(samples.subset(few))
    before = result.table()
    limited = result.limited_table()
    measured = limited.classes == Trust.MEASURED
    assert directional_albedo(before, np.radians([89.0])).max() > 1.02
    assert limited.reached
    assert directional_albedo(limited.table, BETWEEN).max() < 1.0 + 1e-3
    assert np.array_equal(before.values[measured], limited.table.values[measured])
