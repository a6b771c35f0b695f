"""Everything that the page can do, docs/viewer.md does in Python: its lines run as they stand."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.grid import Grid
from brdfit.reconstruct import Reconstruction

from source_tree import ROOT
from viewer_client import Client

PAGE = (ROOT / "docs" / "viewer.md").read_text(encoding="utf-8")
SECTION = PAGE.split("## The same in Python")[1].split("\n## ")[0]


def lines() -> list[tuple[str, str, list[str]]]:
    """Return (what the page does, the code, the modules that it names come from)."""
    found = []
    for what, cell in re.findall(r"^\| ([^|]+) \| (`.+) \|$", SECTION, re.MULTILINE):
        code, _, modules = cell.partition(" (`brdfit.")
        found.append(
            (
                what,
                re.findall(r"`([^`]+)`", code)[0],
                re.findall(r"brdfit\.[\w.]+", "brdfit." + modules) if modules else [],
            )
        )
    return found


@pytest.fixture
def names(
    lobe_csv: Path, sure: Reconstruction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> dict[str, Any]:
    """Return what the lines start from, with fits and pictures that take no time."""
    from PIL import Image

    panorama = tmp_path / "sky.png"
    Image.new("RGB", (96, 48), (90, 120, 200)).save(panorama)
    default = brdfit.Tabulated()
    small = Grid(20, 20, 24)
    fit = brdfit.fit
    monkeypatch.setattr(
        brdfit,
        "fit",
        lambda samples, method=default, **options: fit(samples, method=method, **options),
    )
    monkeypatch.setattr(
        Reconstruction.table, "__defaults__", (small, *Reconstruction.table.__defaults__[1:])
    )
    monkeypatch.setattr(brdfit, "write_table", lambda table, name: None)
    monkeypatch.chdir(tmp_path)
    angles = np.linspace(0.1, 1.0, 5)
    return {
        "brdfit": brdfit,
        "np": np,
        "path": lobe_csv,
        "panorama": panorama,
        "rows": np.arange(90) == 7,
        "stops": 1.0,
        "sure": sure,
        "theta_h": angles,
        "theta_d": angles,
        "phi_d": angles,
        "input": lambda text: Client,
    }


def test_every_line_runs_as_it_stands(
    names: dict[str, Any],
) -> None:
    found = lines()
    assert len(found) > 15
    for what, code, modules in found:
        for module in modules:
            exec(f"from {module} import *", names)
        try:
            exec(code.replace("256", "24"), names)
        except Exception as error:
            raise AssertionError(f"{what}: {code}: {error}") from error


def test_the_page_itself_is_three_lines(names: dict[str, Any], lobe: Reconstruction) -> None:
    block = re.findall(r"```python\n(.*?)```", SECTION, re.DOTALL)[0]
    asked: list[str] = []
    exec(block, {**names, "result": lobe, "input": asked.append})
    assert re.match(r"http://127\.0\.0\.1:\d+/", asked[0])
