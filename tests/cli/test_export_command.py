"""`brdfit export` on good and bad input."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import brdfit.export.outputs as outputs
from brdfit.export import AnalyticSettings
from brdfit.formats import write_table
from brdfit.grid import Grid
from brdfit.models import Ggx
from brdfit.table import Table

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fit small pictures in few steps."""
    whole = outputs.fit_analytic
    quick = AnalyticSettings(size=16, judged=24, steps=6)
    monkeypatch.setattr(outputs, "fit_analytic", lambda t, m, _, p: whole(t, m, quick, p))


@pytest.fixture
def satin(tmp_path: Path) -> Path:
    grid = Grid(60, 20, 12)
    values = np.zeros((grid.size, 3))
    model = Ggx(diffuse=[0.3, 0.2, 0.1], f0=0.04, alpha=0.2)
    values[grid.cells] = model.evaluate(*grid.directions(grid.cells))
    path = tmp_path / "satin.npz"
    write_table(Table(values.reshape(*grid.shape, 3), grid=grid), path)
    return path


def test_export_says_what_it_found_and_what_it_costs(run: Run, satin: Path) -> None:
    code, out, err = run("export", satin, "-o", satin.with_suffix(".gltf"))
    assert code == 0, err
    for expected in ("gltf: dielectric", "roughnessFactor", "perceptual error", "wrote"):
        assert expected in out
    assert satin.with_suffix(".gltf").is_file()


def test_export_prints_json_for_scripts(run: Run, satin: Path) -> None:
    code, out, err = run("export", satin, "-o", satin.with_suffix(".json"), "--json")
    assert code == 0, err
    record = json.loads(out)
    assert record["output"] == "satin.json"
    assert record["models"]["ggx"]["parameters"]["roughness"] == pytest.approx(0.447, abs=0.05)


def test_a_table_that_no_parameters_describe_gives_a_warning(run: Run, tmp_path: Path) -> None:
    grid = Grid(30, 20, 12)
    stripes = 0.1 + 0.5 * (np.arange(30) // 5 % 2)[:, None, None, None] * np.ones((1, 20, 12, 3))
    write_table(Table(stripes, grid=grid), tmp_path / "stripes.npz")
    code, _, err = run("export", tmp_path / "stripes.npz", "-o", tmp_path / "stripes.gltf")
    assert code == 0
    assert "looks like another material" in err


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ("out.binary", "brdfit convert"),
        ("missing/out.gltf", "does not exist"),
    ],
)
def test_a_bad_output_is_refused(run: Run, satin: Path, output: str, said: str) -> None:
    code, _, err = run("export", satin, "-o", satin.parent / output)
    assert code == 2
    assert said in err


def test_samples_are_refused_with_the_way_there(run: Run, paint_csv: Path) -> None:
    code, _, err = run("export", paint_csv, "-o", paint_csv.with_suffix(".gltf"))
    assert code == 2
    assert "brdfit fit" in err
    assert not paint_csv.with_suffix(".gltf").exists()
