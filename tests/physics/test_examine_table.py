"""Each check of a table finds the fault that was put in, and none where none is."""

from __future__ import annotations

import json

import numpy as np
import pytest

from brdfit.arrays import normalize
from brdfit.geometry import cos_incident_outgoing, half_diff_from_directions
from brdfit.models import Ggx, Lambert
from brdfit.physics import Verdict, directional_albedo, examine
from brdfit.table import Table

PAINT = Ggx(diffuse=[0.3, 0.2, 0.1], f0=0.05, alpha=0.15)


class Skewed:
    """A lobe whose peak stands `degrees` off theta_h = 0, all around."""

    def __init__(self, degrees: float) -> None:
        self.off = np.radians(degrees)

    def evaluate(self, wi, wo):
        theta_h = np.arccos(np.clip(normalize(wi + wo)[:, 2], 0.0, 1.0))
        return (0.02 + np.exp(-(((theta_h - self.off) / 0.1) ** 2)))[:, None]


class OneSided:
    """Brighter by a factor on one side of the plane of incidence."""

    def evaluate(self, wi, wo):
        _, _, phi_d = half_diff_from_directions(wi, wo)
        return np.where(np.mod(phi_d, np.pi) < np.pi / 2, 0.2, 0.3)[:, None]


def test_a_model_in_order_is_found_good_by_every_check(table_of):
    health = examine(table_of(PAINT))
    assert health.kind == "table"
    assert {f.verdict for f in health.findings} == {Verdict.GOOD}
    json.dumps(health.record(), allow_nan=False)


def test_missing_negative_and_zero_cells_are_counted_apart(table_of):
    table = table_of(Lambert([0.5, 0.5]))
    values, valid = np.array(table.values), np.array(table.mask)
    cells = table.grid.cells
    valid.reshape(-1)[cells[:100]] = False
    values.reshape(-1, 2)[cells[100:130], 1] = -1e-3
    values.reshape(-1, 2)[cells[130:137], 0] = 0.0
    finding = examine(Table(values=values, grid=table.grid, valid=valid))["cells"]
    counts = {name: finding.details[name] for name in ("missing", "negative", "zero")}
    assert counts == {"missing": 100, "negative": 30, "zero": 7}
    measure = table.grid.solid_angle.reshape(-1)
    assert finding.details["missing_share"] == pytest.approx(measure[cells[:100]].sum())
    assert finding.verdict is not Verdict.GOOD


def test_the_worst_incidence_and_channel_of_the_albedo_are_named(table_of):
    table = table_of(Ggx(diffuse=[0.1, 0.2, 0.8], f0=0.4, alpha=0.3))
    finding = examine(table)["energy"]
    assert finding.verdict is Verdict.WRONG
    assert finding.details["worst_channel"] == "B"
    angle = np.radians(finding.details["worst_theta_i_degrees"])
    assert finding.figure == pytest.approx(directional_albedo(table, angle)[0, 2])
    every = directional_albedo(table, np.radians(finding.details["theta_i_degrees"]))
    assert finding.figure == pytest.approx(every.max())
    assert finding.details["angles_above_one"] == (every > 1.002).any(axis=1).sum()


def test_a_surface_that_is_almost_the_furnace_wants_a_look(table_of):
    assert examine(table_of(Lambert(0.995)))["energy"].verdict is Verdict.LOOK
    assert examine(table_of(Lambert(1.0)))["energy"].verdict is Verdict.LOOK
    assert examine(table_of(Lambert(1.01)))["energy"].verdict is Verdict.WRONG


@pytest.mark.parametrize("noise", [0.1, 0.4])
def test_the_noise_near_grazing_is_what_was_put_in(table_of, noise):
    table = table_of(PAINT)
    grid = table.grid
    cosines = cos_incident_outgoing(
        grid.theta_h[:, None, None], grid.theta_d[None, :, None], grid.phi_d[None, None, :]
    )
    grazing = np.minimum(*cosines) < np.cos(np.radians(72.0))
    scatter = np.random.default_rng(2).lognormal(0.0, noise, grid.shape)
    values = table.values * np.where(grazing, scatter, 1.0)[..., None]
    finding = examine(Table(values=values, grid=grid))["grazing"]
    assert finding.figure == pytest.approx(noise, rel=0.2)
    assert finding.details["inside"] < 0.02


def test_one_brighter_side_is_found(table_of):
    finding = examine(table_of(OneSided()))["symmetry"]
    assert finding.verdict is Verdict.WRONG
    assert finding.figure == pytest.approx(np.log(1.5), rel=1e-3)


@pytest.mark.parametrize("degrees", [0.0, 8.0])
def test_the_peak_stands_where_it_was_put(table_of, degrees):
    finding = examine(table_of(Skewed(degrees)))["peak"]
    assert finding.figure == pytest.approx(degrees, abs=1.0)
    assert finding.verdict is (Verdict.GOOD if degrees == 0.0 else Verdict.WRONG)


def test_a_table_without_a_peak_has_no_position_of_it(table_of):
    assert examine(table_of(Lambert(0.5)))["peak"].verdict is Verdict.UNKNOWN


def test_an_empty_table_gives_findings_not_errors(table_of):
    table = table_of(Lambert(0.5), valid=np.zeros((30, 30, 36), dtype=bool))
    health = examine(table)
    assert health["cells"].verdict is Verdict.WRONG
    assert health["energy"].verdict is Verdict.UNKNOWN


def test_how_negative_a_table_is_stands_in_the_sentence(table_of):
    table = table_of(Ggx(diffuse=[0.1, 0.5], f0=0.3, alpha=0.3))
    values = table.values.copy()
    values.reshape(-1, 2)[table.grid.cells[:3], 1] = -7.0
    sentence = examine(Table(values=values, grid=table.grid))["cells"].sentence
    assert "3 hold a negative value" in sentence
    assert f"down to -7 1/sr in {table.channels[1]}" in sentence
    assert "hold nothing" not in sentence


def test_a_table_without_fault_is_said_to_be_so(table_of):
    table = table_of(Ggx(diffuse=[0.1, 0.5], f0=0.3, alpha=0.3))
    assert examine(table)["cells"].sentence.endswith("hold values above zero")
