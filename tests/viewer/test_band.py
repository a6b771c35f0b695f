"""The 95 % band of a method that states its uncertainty, from the fit to the page and the disk.

The fits are `Posterior`'s own, not stand-ins.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.geometry import directions_from_spherical
from brdfit.grid import Grid
from brdfit.reconstruct import Reconstruction
from brdfit.report.fit_outputs import FitPaths, write_fit
from brdfit.report.page import pictures
from brdfit.report.rgb import rgb_table
from brdfit.report.slice_panel import SlicePanel
from brdfit.viewer.sample_detail import sample_message
from brdfit.viewer.workbench import Workbench

THETA_I = 30.0


def written(result: Reconstruction, path: Path) -> FitPaths:
    """Write the files of a fit, small."""
    paths = FitPaths.beside(path)
    write_fit(result, paths, grid=Grid(30, 30, 36))
    return paths


def half_width(panel: SlicePanel) -> np.ndarray:
    """Return how far the band reaches, in ln f_r, on either side (angles, channels)."""
    for curve in panel.curves:
        assert curve.low is not None
        assert curve.high is not None
        np.testing.assert_allclose(np.multiply(curve.low, curve.high), np.square(curve.value))
    return np.array([np.log(np.divide(c.high, c.value)) for c in panel.curves]).T


def stated(result: Reconstruction, panel: SlicePanel) -> np.ndarray:
    """Return 1.96 times the standard deviation that the method states along a slice."""
    theta_o = np.radians(panel.theta_o)
    wi = directions_from_spherical(np.full(theta_o.shape, np.radians(THETA_I)), np.zeros(1))
    wo = directions_from_spherical(theta_o, np.full(1, np.pi))
    return result.deviations(0.95) * result.stddev(wi, wo)


def test_the_band_of_a_slice_is_the_one_that_the_posterior_states(
    bench: Workbench, sure: Reconstruction
) -> None:
    bench.open(sure)
    panel = bench.store.item("e1").slice(THETA_I, 180.0)
    np.testing.assert_allclose(half_width(panel), stated(sure, panel), rtol=1e-9)


def test_the_band_survives_the_disk(bench: Workbench, sure: Reconstruction, tmp_path: Path) -> None:
    paths = written(sure, tmp_path / "out.npz")
    for path in (paths.table, paths.record, paths.samples):
        bench.open(path)
    for item in bench.store.opened:
        assert item.result is None
        panel = item.slice(THETA_I, 180.0)
        ratio = half_width(panel) / stated(sure, panel)
        # a grid of 6, 3 and 15 degrees in place of the method itself
        assert np.median(np.abs(np.log(ratio))) < 0.05
        assert np.percentile(np.abs(np.log(ratio)), 95) < 0.4


@pytest.mark.parametrize("from_disk", [False, True], ids=["live", "from disk"])
def test_a_sample_stands_against_its_prediction_with_the_band(
    bench: Workbench, sure: Reconstruction, tmp_path: Path, from_disk: bool
) -> None:
    bench.open(written(sure, tmp_path / "out.npz").table if from_disk else sure)
    item = bench.store.item("e1")
    wrong = int(np.flatnonzero(sure.outliers)[0])
    inside = 0
    for index in range(len(sure.samples)):
        detail = sample_message(item, index)
        assert detail.band == ""
        for one in detail.channels:
            assert one.low is not None
            assert one.high is not None
            assert one.prediction is not None
            assert one.value is not None
            assert one.low < one.prediction < one.high
            if index == wrong:
                assert one.value > one.high
            inside += one.low <= one.value <= one.high
    # exact measurements: the band of the BRDF itself holds nearly all
    assert inside > 0.8 * sure.samples.value.size


def test_bands_that_became_rgb_keep_the_prediction_that_judged_each_sample(
    bench: Workbench, sure: Reconstruction, tmp_path: Path
) -> None:
    samples = sure.samples
    spectral = replace(
        samples,
        value=np.repeat(samples.value, 2, axis=1),
        wavelengths=np.linspace(420.0, 680.0, 6),
        channels=(),
    )
    result = sure.method.fit(spectral)
    table = written(result, tmp_path / "out.npz").table
    # what a .binary would hold
    brdfit.write_table(rgb_table(result.table(Grid(30, 30, 36)))[0], table)
    bench.open(table)
    item = bench.store.item("e1")
    assert item.table.n_channels == 3
    expected = result.evaluate(samples.wi[:1], samples.wo[:1])[0]
    detail = sample_message(item, 0)
    assert "the table has 3 channels, the samples 6" in detail.prediction
    assert [one.prediction for one in detail.channels] == pytest.approx(list(expected), rel=1e-5)
    assert all(one.high is not None and one.high > one.prediction for one in detail.channels)
    # and a slice is drawn in the channels of the table, its measurements with it
    panel = item.slice(THETA_I, 180.0)
    names = {curve.channel for curve in panel.curves}
    assert {point.channel for point in panel.points} == names == {"R", "G", "B"}


def test_the_report_draws_the_band_from_the_files_of_the_fit(
    sure: Reconstruction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, "_SIZE", 16)
    paths = written(sure, tmp_path / "out.npz")
    brdfit.write_report(paths.table, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "shaded bands hold 95 %" in text
    assert re.search(r'class="band red"', text)
    data = json.loads(re.findall(r'id="slice-data"[^>]*>(.*?)</script>', text, re.DOTALL)[0])
    curve = data["panels"][0]["curves"][0]
    assert all(
        low < value < high
        for low, value, high in zip(*(curve[k] for k in ("low", "value", "high")), strict=True)
    )


def test_a_method_that_states_none_has_no_band_and_says_so(
    bench: Workbench, lobe: Reconstruction, tmp_path: Path
) -> None:
    class Silent:
        evaluate, dense = lobe.model.evaluate, lobe.model.dense

        def stddev(self, wi: object, wo: object) -> None:
            return None

    mute = replace(lobe, model=Silent())
    bench.open(mute)
    bench.open(written(mute, tmp_path / "out.npz").table)
    for item in bench.store.opened:
        assert item.slice(THETA_I, 180.0).curves[0].low is None
        assert sample_message(item, 0).band == "the method states no uncertainty"
        assert sample_message(item, 0).channels[0].low is None
