"""`brdfit info --physics` and `brdfit repair`, end to end."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brdfit.formats import read_table, write_table
from brdfit.grid import Grid
from brdfit.models import Ggx
from brdfit.table import Table

Run = Callable[..., tuple[int, str, str]]
CHECKS = ("cells", "reciprocity", "energy", "grazing", "symmetry", "peak")


@pytest.fixture
def bright(tmp_path: Path) -> Path:
    """Return a table that reflects too much, with negative cells."""
    grid = Grid(20, 20, 24)
    values = np.zeros((grid.size, 3))
    values[grid.cells] = Ggx(diffuse=[0.1, 0.5, 0.9], f0=0.3, alpha=0.3).evaluate(
        *grid.directions(grid.cells)
    )
    values[grid.cells[:50]] = -1.0
    path = tmp_path / "bright.npz"
    write_table(Table(values=values.reshape(*grid.shape, 3), grid=grid), path)
    return path


def test_physics_gives_every_check_a_verdict_and_a_sentence(run: Run, bright: Path) -> None:
    code, out, err = run("info", bright, "--physics")
    assert code == 0, err
    lines = {line.split()[0]: line for line in out.splitlines() if line.startswith("  ")}
    assert all(name in lines for name in CHECKS)
    assert "wrong: directional albedo is at most" in lines["energy"]


def test_physics_as_json_holds_the_figures(run: Run, bright: Path) -> None:
    code, out, _ = run("info", bright, "--physics", "--json")
    record = json.loads(out)
    assert code == 0
    assert record["kind"] == "table"
    assert record["physics"]["worst"] == "wrong"
    found = {finding["name"]: finding for finding in record["physics"]["findings"]}
    assert tuple(found) == CHECKS
    assert found["energy"]["figure"] > 1.1
    assert found["cells"]["details"]["negative"] == 50


def test_without_physics_info_is_as_it_was(run: Run, bright: Path) -> None:
    assert "physics" not in json.loads(run("info", bright, "--json")[1])


@pytest.mark.parametrize("which", ["table", "samples"])
def test_the_findings_are_drawn(
    run: Run, bright: Path, paint_csv: Path, tmp_path: Path, which: str
) -> None:
    from matplotlib.image import imread

    source = bright if which == "table" else paint_csv
    picture = tmp_path / "health.png"
    code, _, err = run("info", source, "--physics", "--picture", picture)
    assert code == 0, err
    pixels = imread(picture)[..., :3]
    assert pixels.shape[:2] == (620, 1300)
    assert 0.001 < (pixels < 0.5).any(axis=2).mean() < 0.3


@pytest.mark.parametrize(
    ("words", "said"),
    [(("--picture", "x.png"), "--physics"), (("--physics", "--picture", "x.gif"), ".png")],
)
def test_a_picture_that_cannot_be_drawn_is_refused(
    run: Run, bright: Path, words: tuple[str, ...], said: str
) -> None:
    code, _, err = run("info", bright, *words)
    assert code == 2
    assert said in err


def test_repair_writes_what_physics_allows_and_lists_it(
    run: Run, bright: Path, tmp_path: Path
) -> None:
    out_file = tmp_path / "good.npz"
    code, out, err = run("repair", bright, "-o", out_file)
    assert code == 0, err
    for said in ("50 cells hold a negative value", "50 cells (", "cells were lowered"):
        assert said in out
    table = read_table(out_file)
    assert table.missing == 0
    assert table.values.min() >= 0.0
    assert any("lowered" in note for note in table.source.notes)
    again = json.loads(run("info", out_file, "--physics", "--json")[1])
    assert {f["name"]: f["verdict"] for f in again["physics"]["findings"]}["energy"] != "wrong"


def test_repair_as_json(run: Run, bright: Path, tmp_path: Path) -> None:
    code, out, _ = run("repair", bright, "-o", tmp_path / "good.npz", "--json", "--keep-missing")
    record = json.loads(out)
    assert code == 0
    assert [change["name"] for change in record["changes"]] == ["negative", "energy"]
    assert record["input"]["sha256"]


def test_repair_of_samples_keeps_them_samples(run: Run, paint_csv: Path, tmp_path: Path) -> None:
    code, out, err = run("repair", paint_csv, "-o", tmp_path / "paint.parquet")
    assert code == 0, err
    assert "reciprocity" in out


def test_repair_does_not_write_over_its_input(run: Run, bright: Path) -> None:
    code, _, err = run("repair", bright, "-o", bright)
    assert code == 2
    assert "is the input" in err


def test_a_format_that_cannot_be_written_is_refused_before_the_work(
    run: Run, tmp_path: Path
) -> None:
    code, _, err = run("repair", tmp_path / "none.binary", "-o", tmp_path / "out.xyz")
    assert code == 2
    assert "'.xyz' does not say how to write a file" in err
