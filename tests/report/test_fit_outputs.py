from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import brdfit.report.fit_outputs as fit_outputs
from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.formats import read_samples, read_table
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.reconstruct.result import Model, Reconstruction
from brdfit.report.fit_figure import slices_of
from brdfit.report.fit_outputs import FitPaths, write_fit
from brdfit.samples import Samples

Fit = Callable[..., Reconstruction]
COARSE = Grid(9, 8, 10)
BANDS = np.arange(400.0, 701.0, 50.0)


def test_a_fit_leaves_a_table_a_picture_a_record_and_the_samples(
    tmp_path: Path, fit_known: Fit
) -> None:
    result = fit_known()
    paths = FitPaths.beside(tmp_path / "out.binary")
    write_fit(result, paths, context={"command": "fit"})
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "out.binary",
        "out.csv",
        "out.json",
        "out.png",
    ]
    table = read_table(paths.table)
    cells = table.grid.cells[::5000]
    expected = result.evaluate(*table.grid.directions(cells))
    assert table.values.reshape(-1, 3)[cells] == pytest.approx(expected, rel=1e-6)
    assert paths.picture.read_bytes().startswith(b"\x89PNG")


def test_the_record_holds_what_a_script_needs(tmp_path: Path, fit_known: Fit) -> None:
    result = fit_known()
    paths = FitPaths.beside(tmp_path / "out.npz")
    written = write_fit(
        result, paths, context={"command": "fit", "warnings": ["W: x"]}, grid=COARSE
    )
    record = json.loads(paths.record.read_text())
    assert record == json.loads(json.dumps(written.record))
    assert record["schema"] == "brdfit.fit/1"
    assert record["outputs"] == {
        "table": "out.npz",
        "picture": "out.png",
        "record": "out.json",
        "samples": "out.csv",
    }
    assert record["outcome"]["name"] == "converged"
    assert record["outliers"]["count"] == int(result.outliers.sum()) >= 1
    assert record["coverage"]["theta_i"] == pytest.approx([10.0, 50.0])
    assert record["warnings"] == ["W: x"]
    assert record["samples"]["source"]["name"] == "arrays"
    assert "numpy" in record["versions"]


def test_the_record_tells_the_albedo_of_the_table_and_where_the_result_comes_from(
    tmp_path: Path, fit_known: Fit
) -> None:
    result = fit_known()
    record = write_fit(result, FitPaths.beside(tmp_path / "out.npz"), grid=COARSE).record
    albedo = record["albedo"]
    at = np.radians(albedo["theta_i_degrees"])
    expected = directional_albedo(result.table(COARSE), at)
    found = np.array([albedo["values"][name] for name in ("R", "G", "B")]).T
    assert found == pytest.approx(expected, abs=1e-4)
    assert albedo["largest"] == pytest.approx(expected.max())
    assert albedo["limited"] is None
    assert record["trust"]["definition"] == result.trust_map.definition
    assert sum(record["trust"]["shares"].values()) == pytest.approx(1.0)


def test_a_limited_fit_says_what_it_cost_and_leaves_the_residuals_alone(
    tmp_path: Path, fit_known: Fit
) -> None:
    result = fit_known()
    bright = replace(result, model=Bright(result.model))
    plain = write_fit(bright, FitPaths.beside(tmp_path / "plain.npz"), grid=Grid(24, 24, 24))
    paths = FitPaths.beside(tmp_path / "limited.npz")
    limited = write_fit(bright, paths, grid=Grid(24, 24, 24), limit_albedo=True)
    assert plain.albedo.above_one
    told = limited.record["albedo"]["limited"]
    assert told["largest_after"] < 0.5 * told["largest_before"]
    assert told["cells_lowered"]["measured"] == 0
    assert told["cells_lowered"]["supplied"] > 0
    found = directional_albedo(read_table(paths.table), np.radians([85.0])).max()
    assert found < 0.5 * directional_albedo(plain.table, np.radians([85.0])).max()
    assert found <= limited.record["albedo"]["largest"] + 1e-6
    assert paths.samples.read_bytes() == (tmp_path / "plain.csv").read_bytes()


@dataclass(frozen=True)
class Bright:
    """A model beside which grazing directions are brighter than any surface."""

    inner: Model

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        grazing = np.clip((0.3 - np.minimum(wi[:, 2], wo[:, 2])) / 0.2, 0.0, 1.0)
        return self.inner.evaluate(wi, wo) * (1.0 + 5.0 * grazing)[:, None]

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return grid.spread(self.evaluate(*grid.directions(grid.cells)))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray | None:
        return None


def test_the_samples_file_reads_back_as_the_same_samples(tmp_path: Path, fit_known: Fit) -> None:
    result = fit_known()
    paths = FitPaths.beside(tmp_path / "out.npz")
    write_fit(result, paths, grid=COARSE)
    with pytest.warns(match="cannot be used"):
        again = read_samples(paths.samples)
    assert again.wi == pytest.approx(result.samples.wi, abs=1e-9)
    assert again.wo == pytest.approx(result.samples.wo, abs=1e-9)
    assert again.value == pytest.approx(result.samples.value, nan_ok=True)
    assert again.channels == ("R", "G", "B")


def test_the_samples_file_says_row_weight_outlier_and_residual(
    tmp_path: Path, fit_known: Fit
) -> None:
    from pyarrow import csv

    result = fit_known()
    paths = FitPaths.beside(tmp_path / "out.npz")
    write_fit(result, paths, grid=COARSE)
    columns = csv.read_csv(paths.samples).to_pydict()
    assert columns["brdfit_row"] == list(result.samples.rows)
    assert columns["outlier"] == [int(outlier) for outlier in result.outliers]
    assert columns["weight"] == pytest.approx(result.weights)
    assert columns["residual_G"][4] == pytest.approx(np.log(8.0))
    assert columns["residual_R"][7] is None
    assert columns["flags"][9] == "not_finite"
    assert columns["R"][9] is None


def test_bands_become_rgb_in_a_binary_and_stay_in_an_npz(tmp_path: Path, fit_known: Fit) -> None:
    result = fit_known(len(BANDS), BANDS)
    binary = write_fit(result, FitPaths.beside(tmp_path / "a.binary"))
    assert binary.conversion.kind == "spectral"
    assert binary.record["channels_written"]["from_channels"] == len(BANDS)
    assert read_table(tmp_path / "a.binary").n_channels == 3
    npz = write_fit(result, FitPaths.beside(tmp_path / "b.npz"))
    assert npz.conversion.kind == "none"
    assert read_table(tmp_path / "b.npz").n_channels == len(BANDS)


def test_if_one_output_cannot_be_made_there_is_none(
    tmp_path: Path, fit_known: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fit_outputs, "write_samples_csv", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_fit(fit_known(), FitPaths.beside(tmp_path / "out.npz"), grid=COARSE)
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_suffix_is_refused_with_the_formats_there_are(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.xyz.*\.binary"):
        FitPaths.beside(tmp_path / "out.xyz")


def test_a_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="does not exist"):
        FitPaths.beside(tmp_path / "missing" / "out.binary")


def test_the_table_never_replaces_the_input(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is the input"):
        FitPaths.beside(tmp_path / "in.npz", inputs=[tmp_path / "in.npz"])


def test_a_file_beside_the_table_makes_way_for_the_input(tmp_path: Path) -> None:
    paths = FitPaths.beside(tmp_path / "paint.binary", inputs=[tmp_path / "paint.csv"])
    assert paths.samples.name == "paint.fit.csv"
    assert paths.record.name == "paint.json"


def test_slices_hold_the_samples_of_their_plane(lobe_samples: Callable[..., Samples]) -> None:
    samples = lobe_samples()
    slices = slices_of(samples)
    assert [round(float(np.degrees(one.theta_i))) for one in slices] == [10, 30, 50]
    fixed = slices[1]
    # light or, by reciprocity, detector at 30 degrees; the azimuth of 90 is off the plane
    directions = np.degrees(np.arccos(np.stack([samples.wi[:, 2], samples.wo[:, 2]])))
    assert np.all(np.abs(directions[:, fixed.rows] - 30.0).min(axis=0) < 3.0)
    assert np.degrees(fixed.theta_o).min() < -60.0
    assert np.degrees(fixed.theta_o).max() > 60.0
