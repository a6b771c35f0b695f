"""A repair changes what it says it changes, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.models import Ggx, Lambert
from brdfit.physics import examine, repair_samples, repair_table
from brdfit.table import Table

PAINT = Ggx(diffuse=[0.3, 0.2], f0=0.05, alpha=0.3)


def change(repair, name):
    return next(one for one in repair.changes if one.name == name)


def holed(table, seed=4):
    """A table with a block of cells missing and some negative."""
    values, valid = np.array(table.values), np.array(table.mask)
    valid[10:14, 8:12, 5:15] = False
    values[4:6, 4:6, 20:24] = -0.5
    return Table(values=values, grid=table.grid, valid=valid)


def test_a_table_in_order_comes_back_as_it_went_in(table_of):
    table = table_of(PAINT)
    repair = repair_table(table)
    assert repair.changed == 0
    assert np.array_equal(repair.content.values, table.values)
    assert repair.content.source is table.source


def test_negative_and_missing_cells_are_filled_near_the_truth_and_counted(table_of):
    table = table_of(PAINT)
    broken = holed(table)
    repair = repair_table(broken)
    negative, filled = change(repair, "negative"), change(repair, "fill")
    assert negative.count == 2 * 2 * 4
    assert negative.figures["lowest"] == -0.5
    assert filled.count == broken.missing + negative.count
    assert repair.content.missing == 0
    lost = table.mask & ~(broken.mask & (broken.values >= 0.0).all(axis=3))
    error = np.abs(np.log(repair.content.values[lost] / table.values[lost]))
    assert error.mean() < 0.05
    assert np.array_equal(repair.content.values[~lost], broken.values[~lost])


def test_missing_cells_stay_missing_where_that_is_wanted(table_of):
    broken = holed(table_of(PAINT))
    repair = repair_table(broken, fill=False)
    assert repair.content.missing == broken.missing + 16
    assert [one.name for one in repair.changes] == ["negative", "energy"]


def test_a_whole_row_of_phi_d_is_filled_across_the_seam(table_of):
    table = table_of(PAINT)
    valid = np.array(table.mask)
    valid[3:6, 3:6, [0, 1, -1]] = False
    repaired = repair_table(Table(values=table.values, grid=table.grid, valid=valid)).content
    lost = table.mask & ~valid
    np.testing.assert_allclose(repaired.values[lost], table.values[lost], rtol=0.05)


def test_energy_is_taken_from_what_nobody_measured_first(table_of):
    table = table_of(Ggx(diffuse=0.46, f0=0.62, alpha=0.5))
    repair = repair_table(table)
    energy = change(repair, "energy")
    assert energy.count > 0
    assert energy.figures["albedo_before"] > 1.01
    assert energy.figures["albedo_after"] <= 1.0
    assert energy.figures["reliable"] < energy.count / 10
    assert examine(repair.content)["energy"].figure <= 1.002


def test_both_sides_are_averaged_only_where_that_is_asked_for(table_of):
    table = table_of(Lambert(0.5))
    values = np.array(table.values)
    values[:, :, 1:18] *= 1.2
    skewed = Table(values=values, grid=table.grid)
    assert repair_table(skewed).changed == 0
    repair = repair_table(skewed, symmetrize=True)
    assert change(repair, "symmetry").figures["largest_difference"] == pytest.approx(0.2 / 2.2)
    assert examine(repair.content)["symmetry"].figure < 1e-9
    assert repair.content.values[5, 5, 5] == pytest.approx(1.1 * 0.5 / np.pi)


def test_the_changes_travel_in_the_notes_of_the_source(table_of):
    repair = repair_table(holed(table_of(PAINT)))
    notes = repair.content.source.notes
    assert len(notes) == repair.changed == 2
    assert all(note.startswith("repair: ") for note in notes)


def test_exchanged_samples_get_their_mean_and_others_stay(measured):
    samples = measured(Lambert(0.5))
    higher = samples.wi[:, 2] > samples.wo[:, 2] + 1e-9
    samples = samples.with_value(samples.value * np.where(higher, 1.2, 1.0)[:, None])
    assert examine(samples)["reciprocity"].figure == pytest.approx(np.log(1.2))
    repair = repair_samples(samples)
    reciprocity = change(repair, "reciprocity")
    assert reciprocity.count > 20
    assert reciprocity.figures["largest_difference"] == pytest.approx(0.2 / 1.1)
    changed = (repair.content.value != samples.value).any(axis=1)
    assert changed.sum() == 2 * reciprocity.count
    np.testing.assert_allclose(repair.content.value[changed], 1.1 * 0.5 / np.pi)
    assert len(repair.content) == len(samples)


def test_samples_in_order_come_back_as_they_went_in(measured):
    samples = measured(Lambert(0.5))
    repair = repair_samples(samples)
    assert repair.changed == 0
    assert repair.content is samples


def test_a_negative_channel_is_filled_and_the_others_are_kept(table_of):
    table = table_of(PAINT)
    values = np.array(table.values)
    values[4:8, 4:8, 20:24, 1] = -0.5
    repair = repair_table(Table(values=values, grid=table.grid))
    assert np.array_equal(repair.content.values[..., 0], table.values[..., 0])
    np.testing.assert_allclose(
        repair.content.values[4:8, 4:8, 20:24, 1], table.values[4:8, 4:8, 20:24, 1], rtol=0.1
    )
    assert change(repair, "negative").figures == {"lowest": -0.5, "values": 64}
    assert "not their other channels" in change(repair, "negative").sentence


def test_a_channel_that_is_negative_everywhere_has_nothing_to_be_filled_from(table_of):
    table = table_of(PAINT)
    values = np.array(table.values)
    values[..., 1] = -1.0
    repair = repair_table(Table(values=values, grid=table.grid))
    assert np.array_equal(repair.content.values[..., 0], table.values[..., 0])
    assert "stays as it is" in change(repair, "fill").sentence
    assert change(repair, "fill").figures["empty_channels"] == [table.channels[1]]
