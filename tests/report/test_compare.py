"""Comparing two BRDFs: laws, channels that differ, and what is said about it."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from brdfit.errors import MissingExtra, UsageError
from brdfit.grid import Grid
from brdfit.metrics import METRICS
from brdfit.report.compare import compare
from brdfit.samples import Samples
from brdfit.table import Table

GRID = Grid(12, 10, 14)
IMAGE_METRICS = [name for name, metric in METRICS.items() if metric.compares == "images"]
VALUE_METRICS = [name for name, metric in METRICS.items() if metric.compares == "values"]


class Lobe:
    """Diffuse plus a lobe, in any number of channels."""

    def __init__(self, *diffuse: float) -> None:
        self.diffuse = np.array(diffuse)

    def evaluate(self, wi, wo):
        half = wi + wo
        cosine = half[:, 2] / np.linalg.norm(half, axis=1)
        return self.diffuse / np.pi + 0.2 * cosine[:, None] ** 10


def table_of(brdf, grid=GRID, **keywords):
    value = brdf.evaluate(*grid.directions(grid.cells))
    dense = np.full((grid.size, value.shape[1]), np.nan)
    dense[grid.cells] = value
    return Table(values=dense.reshape(*grid.shape, -1), grid=grid, **keywords)


@pytest.fixture(scope="module")
def paint():
    return table_of(Lobe(0.4, 0.2, 0.1))


def test_a_table_compared_with_itself_is_identical_under_every_metric(paint):
    found = compare(paint, paint, size=16)
    assert found.perceptual_error == 0.0
    for metrics in found.images.values():
        for name, value in metrics.items():
            assert value == pytest.approx(METRICS[name].identical, abs=1e-6)
    assert all(score == (0.0, 3 * GRID.cells.size, 0) for score in found.values.values())


def test_every_metric_is_there_under_two_illuminations(paint):
    pytest.importorskip("skimage")
    pytest.importorskip("flip_evaluator")
    found = compare(paint, table_of(Lobe(0.3, 0.2, 0.1)), size=16)
    assert list(found.images) == ["studio", "point"]
    for metrics in found.images.values():
        assert list(metrics) == IMAGE_METRICS
    assert list(found.values) == VALUE_METRICS
    assert found.absent == {}
    assert found.perceptual_error == found.images["studio"]["perceptual_error"] > 0.5


def test_a_constant_factor_shows_as_its_logarithm(paint):
    brighter = Table(values=paint.values * 1.1, grid=GRID)
    found = compare(paint, brighter, size=16, illuminations=["point"])
    assert found.values["log_rms"].value == pytest.approx(math.log(1.1))
    assert found.values["mean_abs_log"].value == pytest.approx(math.log(1.1))
    assert list(found.images) == ["point"]
    assert math.isnan(found.perceptual_error)


def test_cells_that_hold_nothing_are_skipped_and_counted(paint):
    valid = paint.mask.copy()
    holes = np.flatnonzero(valid.reshape(-1))[::7]
    valid.reshape(-1)[holes] = False
    holed = Table(values=paint.values, grid=GRID, valid=valid)
    found = compare(paint, holed, size=16)
    assert found.values["log_rms"] == (0.0, 3 * (GRID.cells.size - holes.size), 3 * holes.size)


def test_a_table_is_close_to_the_function_it_was_made_from():
    material = Lobe(0.4, 0.2, 0.1)
    fine = table_of(material, Grid(45, 45, 30))
    found = compare(material, fine, size=16)
    assert found.perceptual_error < 0.2
    assert found.values["mean_abs_log"].value < 0.01
    assert any("45 x 45 x 90 grid" in note for note in found.notes)


def test_different_channels_meet_in_linear_srgb_and_that_is_said():
    bands = np.arange(400.0, 701.0, 20.0)
    grey = table_of(Lobe(*np.full(16, 0.3)), wavelengths=bands)
    found = compare(grey, table_of(Lobe(0.3, 0.3, 0.3)), size=16)
    assert found.channels == ("R", "G", "B")
    assert any("linear sRGB" in note for note in found.notes)
    assert found.perceptual_error < 0.5
    assert found.values["log_rms"].value < 0.05


def test_samples_are_compared_at_their_own_directions(paint, random_directions):
    wi, wo = random_directions(40)
    value = 1.2 * paint.evaluate(wi, wo)
    value[3, 1] = np.nan
    wo = wo.copy()
    wo[5, 2] *= -1.0
    found = compare(Samples(wi=wi, wo=wo, value=value), paint)
    assert found.directions == 39
    assert found.values["mean_abs_log"].value == pytest.approx(math.log(1.2))
    assert found.values["mean_abs_log"].skipped == 1
    assert found.images == {}
    assert any("no sphere" in note for note in found.notes)


def test_a_missing_extra_leaves_its_metric_out_with_the_hint(paint, monkeypatch):
    def missing(*_args):
        raise MissingExtra("scikit-image", "metrics", "SSIM")

    monkeypatch.setitem(METRICS, "ssim", replace(METRICS["ssim"], function=missing))
    found = compare(paint, paint, size=16)
    assert "brdfit[metrics]" in found.absent["ssim"]
    assert "ssim" not in found.images["studio"]
    assert found.perceptual_error == 0.0


def test_the_record_is_json_without_words_that_are_not_in_json(paint):
    text = json.dumps(compare(paint, paint, size=16).to_dict(), allow_nan=False)
    record = json.loads(text)
    assert record["images"]["studio"]["psnr"] == "inf"
    assert record["values"]["log_rms"] == {
        "value": 0.0,
        "used": 3 * GRID.cells.size,
        "skipped": 0,
    }


def test_an_unknown_illumination_is_refused_with_the_names_there_are(paint):
    with pytest.raises(UsageError, match="found 'sun' but there are studio, point"):
        compare(paint, paint, illuminations=["sun"])
