"""`brdfit render --renderer mitsuba`, with Mitsuba and without it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brdfit.errors import BrdfitError
from brdfit.formats import write_table
from brdfit.grid import MERL_GRID
from brdfit.mitsuba.library import require_llvm
from brdfit.table import Table

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def grey_table(tmp_path: Path) -> Path:
    """Return a .binary of albedo 0.5 in all cells."""
    path = tmp_path / "grey.binary"
    write_table(Table(values=np.full((*MERL_GRID.shape, 3), 0.5 / np.pi)), path)
    return path


def test_mitsuba_renders_the_same_sphere(run: Run, grey_table: Path, tmp_path: Path) -> None:
    from matplotlib.image import imread

    pytest.importorskip("mitsuba", reason="the extra mitsuba is not installed")
    try:
        require_llvm()
    except BrdfitError as error:
        pytest.skip(str(error))
    pictures = []
    for renderer in ("brdfit", "mitsuba"):
        path = tmp_path / f"{renderer}.png"
        words = ("--renderer", renderer, "--size", "24", "--illumination", "point")
        code, out, err = run("render", grey_table, "-o", path, *words)
        assert code == 0, err
        pictures.append(imread(path)[6:18, 6:18, :3])
    assert "by Mitsuba" in out
    assert "256 rays per pixel" in out
    assert np.abs(pictures[0] - pictures[1]).max() < 0.02


def test_without_mitsuba_it_says_what_to_install(
    run: Run, grey_table: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.startswith("brdfit.mitsuba")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    picture = tmp_path / "a.png"
    code, _, err = run("render", grey_table, "-o", picture, "--renderer", "mitsuba")
    assert code == 1
    assert 'python -m pip install "brdfit[mitsuba]"' in err
    assert not picture.exists()


def test_renderers_and_samples_that_mean_nothing_are_refused(
    run: Run, grey_table: Path, tmp_path: Path
) -> None:
    for words, said in (
        (("--renderer", "mistuba"), "mitsuba"),
        (("--samples", "1"), "found 1 but a pixel needs 2 or more"),
    ):
        code, _, err = run("render", grey_table, "-o", tmp_path / "a.png", *words)
        assert code == 2
        assert said in err
