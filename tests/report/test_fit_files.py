from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import brdfit.report.fit_outputs as fit_outputs
from brdfit.errors import CorruptFile, UsageError
from brdfit.files import sha256_of_file
from brdfit.formats import read_table, write_table
from brdfit.grid import Grid
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.fit_files import FitFiles, read_fit
from brdfit.report.fit_outputs import FitPaths, write_fit
from brdfit.report.fitted import Fitted
from brdfit.table import Table

Fit = Callable[..., Reconstruction]


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the picture empty: drawing it takes longer than everything else here."""
    monkeypatch.setattr(fit_outputs, "draw_fit", lambda *_: None)


@pytest.fixture
def left(tmp_path: Path, fit_known: Fit) -> Path:
    """Write the files of a fit on a coarse grid; return the table's path."""
    write_fit(fit_known(), FitPaths.beside(tmp_path / "paint.npz"), grid=Grid(30, 30, 36))
    return tmp_path / "paint.npz"


def _read(path: Path) -> Fitted:
    files = FitFiles.around(path)
    assert files is not None
    return read_fit(files)


@pytest.mark.parametrize("suffix", [".npz", ".json", ".csv"])
def test_each_file_leads_to_the_others(left: Path, suffix: str) -> None:
    assert FitFiles.around(left.with_suffix(suffix)) == FitFiles(
        left, left.with_suffix(".json"), left.with_suffix(".csv")
    )


def test_what_is_read_back_is_what_the_fit_knew(left: Path, fit_known: Fit) -> None:
    result, fitted = fit_known(), _read(left)
    assert fitted.judged is not None
    assert fitted.name == "arrays"
    assert fitted.judged.rows == list(result.samples.rows)  # type: ignore[arg-type]
    assert fitted.judged.weights == pytest.approx(result.weights)
    assert fitted.judged.residuals == pytest.approx(result.residuals, nan_ok=True)
    assert np.array_equal(fitted.judged.outliers, result.outliers)
    assert fitted.record["outcome"]["name"] == "converged"
    assert {file.role: file.sha256 for file in fitted.files}["table"] == sha256_of_file(left)
    assert fitted.notes == ()


def test_a_set_that_was_renamed_together_stays_together(left: Path) -> None:
    for suffix in (".npz", ".json", ".csv"):
        shutil.copy(left.with_suffix(suffix), left.with_name(f"other{suffix}"))
    fitted = _read(left.with_name("other.npz"))
    assert [file.name for file in fitted.files] == ["other.npz", "other.json", "other.csv"]
    assert any("is the record of a table called 'paint.npz'" in note for note in fitted.notes)


def test_what_is_missing_is_said(left: Path) -> None:
    left.with_suffix(".csv").unlink()
    assert [note for note in _read(left).notes if "no samples of a fit (paint.csv)" in note]
    left.with_suffix(".json").unlink()
    fitted = _read(left)
    assert [note for note in fitted.notes if "no readable record of a fit (paint.json)" in note]
    assert (fitted.judged, fitted.record) == (None, {})


def test_measurements_named_like_the_table_are_not_taken_for_its_samples(
    left: Path, tmp_path: Path
) -> None:
    left.with_suffix(".csv").write_text("theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,value\n")
    assert FitFiles.around(left.with_suffix(".csv")) is None
    assert _read(left).judged is None


def test_the_files_that_made_way_for_an_input_are_found(tmp_path: Path, fit_known: Fit) -> None:
    source = tmp_path / "paint.csv"
    source.write_text("theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,value\n")
    paths = FitPaths.beside(tmp_path / "paint.npz", inputs=[source])
    write_fit(fit_known(), paths, grid=Grid(9, 8, 10))
    assert FitFiles.around(paths.table) == FitFiles(paths.table, paths.record, paths.samples)
    assert FitFiles.around(paths.samples) == FitFiles(paths.table, paths.record, paths.samples)


def test_a_table_of_another_fit_is_noticed(left: Path) -> None:
    table = read_table(left)
    write_table(Table(values=table.values * 1.5, grid=table.grid, channels=table.channels), left)
    assert [note for note in _read(left).notes if "not of one fit" in note]


def test_a_damaged_record_is_an_error_if_named_and_a_note_if_not(left: Path) -> None:
    left.with_suffix(".json").write_text("{")
    with pytest.raises(CorruptFile, match=r"paint\.json: is not JSON"):
        FitFiles.around(left.with_suffix(".json"))
    assert [note for note in _read(left).notes if "no readable record" in note]


def test_json_of_another_kind_is_of_no_fit(left: Path) -> None:
    left.with_suffix(".json").write_text('{"schema": "something/1"}')
    assert FitFiles.around(left.with_suffix(".json")) is None


def test_a_record_without_its_table_says_which_is_missing(left: Path) -> None:
    left.unlink()
    with pytest.raises(UsageError, match=r"whose table 'paint\.npz' is not beside it"):
        FitFiles.around(left.with_suffix(".json"))


def test_a_record_never_leads_out_of_its_folder(left: Path, tmp_path: Path) -> None:
    outside = tmp_path / "below"
    outside.mkdir()
    record = json.loads(left.with_suffix(".json").read_text())
    record["outputs"]["table"] = "../paint.npz"
    (outside / "paint.json").write_text(json.dumps(record))
    with pytest.raises(UsageError, match="is not beside it"):
        FitFiles.around(outside / "paint.json")


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda text: text.replace("weight", "wait"), "'weight' is missing"),
        (lambda text: text.replace("residual_", "rest_"), "is missing"),
        (lambda text: text.replace("weight", "w", 1).replace("flags", "weight", 1), "numbers"),
    ],
)
def test_damaged_samples_are_refused_by_name(
    left: Path, damage: Callable[[str], str], says: str
) -> None:
    path = left.with_suffix(".csv")
    path.write_text(damage(path.read_text()))
    with pytest.raises(CorruptFile, match=rf"paint\.csv.*({says})"):
        _read(left)
