"""What a record keeps of the trust map is what the fit told."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import brdfit.report.fit_outputs as fit_outputs
from brdfit.arrays import FloatArray
from brdfit.errors import CorruptFile
from brdfit.geometry import half_diff_from_directions
from brdfit.grid import Grid
from brdfit.progress import Progress
from brdfit.reconstruct.result import Reconstruction
from brdfit.reconstruct.trust import Trust
from brdfit.report.fit_files import FitFiles, read_fit
from brdfit.report.fit_outputs import FitPaths, write_fit
from brdfit.report.fitted import Fitted

Fit = Callable[..., Reconstruction]
Draw = Callable[[int], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class Sure:
    """Told much by its samples near the peak, little elsewhere."""

    noise: float = 0.01

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return np.ones((len(wi), 3))

    def dense(self, grid: Grid, progress: Progress) -> FloatArray:
        return grid.spread(np.ones((grid.cells.size, 3)))

    def stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        theta_h, _, _ = half_diff_from_directions(wi, wo)
        return (0.1 + 0.8 * theta_h)[:, None] * np.ones(3)

    def prior_stddev(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        _, theta_d, _ = half_diff_from_directions(wi, wo)
        return 1.0 + 0.3 * theta_d


@pytest.fixture(autouse=True)
def _no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fit_outputs, "draw_fit", lambda *_: None)


@pytest.fixture
def sure(fit_known: Fit) -> Reconstruction:
    """Return a fit that knows its prior."""
    return replace(fit_known(), model=Sure())


def reopened(result: Reconstruction, folder: Path) -> Fitted:
    """Write a fit and read it again."""
    paths = FitPaths.beside(folder / "out.npz")
    write_fit(result, paths, grid=Grid(9, 8, 10))
    files = FitFiles.around(paths.table)
    assert files is not None
    return read_fit(files)


def test_a_fit_opened_again_gives_the_classes_that_it_gave(
    sure: Reconstruction, tmp_path: Path, random_directions: Draw
) -> None:
    fitted = reopened(sure, tmp_path)
    assert fitted.trust is not None
    assert fitted.trust.map.definition == sure.trust_map.definition
    samples = sure.samples
    usable = samples.usable.any(axis=1)
    for wi, wo in (random_directions(2_000), (samples.wi[usable], samples.wo[usable])):
        own, kept = sure.trust(wi, wo), fitted.trust.map.evaluate(wi, wo)
        # the doubt is interpolated between coarse nodes: classes may differ at their borders
        assert np.mean(own == kept) > 0.97
    assert set(own) == {1, 2, 3}  # nearness alone would call all of them measured


def test_what_is_named_as_an_outlier_supports_nothing_after_reopening(
    fit_known: Fit, tmp_path: Path
) -> None:
    result = fit_known()
    only = np.ones(len(result.samples), dtype=bool)
    result = replace(result, outliers=only & result.samples.usable.any(axis=1))
    fitted = reopened(result, tmp_path)
    assert fitted.trust is not None
    assert fitted.trust.shares == (0.0, 0.0, pytest.approx(1.0))
    at = result.samples.wi[:4], result.samples.wo[:4]
    assert (fitted.trust.map.evaluate(*at) == Trust.SUPPLIED).all()


def test_a_method_that_states_nothing_is_told_by_distance(
    fit_known: Fit, tmp_path: Path, random_directions: Draw
) -> None:
    result = fit_known()
    fitted = reopened(result, tmp_path)
    assert fitted.record["trust"]["prior"] is None
    assert fitted.trust is not None
    at = random_directions(500)
    assert np.array_equal(fitted.trust.map.evaluate(*at), result.trust(*at))


def test_the_shares_are_those_of_the_classes(sure: Reconstruction, tmp_path: Path) -> None:
    kept = reopened(sure, tmp_path).trust
    assert kept is not None
    grid = Grid(45, 45, 30)
    own = sure.trust_map.on_grid(grid)
    shares = [grid.solid_angle[own == trust].sum() for trust in (1, 2, 3)]
    assert kept.shares == pytest.approx(shares, abs=0.02)


def test_it_stays_small(sure: Reconstruction, tmp_path: Path) -> None:
    assert len(json.dumps(reopened(sure, tmp_path).record["trust"])) < 20_000


def test_an_older_record_has_none(sure: Reconstruction, tmp_path: Path) -> None:
    reopened(sure, tmp_path)
    record = json.loads((tmp_path / "out.json").read_text())
    del record["trust"]
    (tmp_path / "out.json").write_text(json.dumps(record))
    files = FitFiles.around(tmp_path / "out.npz")
    assert files is not None
    assert read_fit(files).trust is None


def test_a_damaged_record_is_refused_by_name(sure: Reconstruction, tmp_path: Path) -> None:
    reopened(sure, tmp_path)
    whole = json.loads((tmp_path / "out.json").read_text())
    bomb = base64.b64encode(zlib.compress(bytes(10_000_000))).decode()
    prior = whole["trust"]["prior"]
    for damage in (
        {"trust": {**whole["trust"], "shares": {}}},
        {"trust": {**whole["trust"], "prior": {**prior, "values": "not base64!"}}},
        {"trust": {**whole["trust"], "prior": {**prior, "values": "AAAA"}}},
        {"trust": {**whole["trust"], "prior": {**prior, "values": bomb}}},
        {"trust": {**whole["trust"], "prior": {**prior, "shape": [2, 2]}}},
        {"trust": {**whole["trust"], "prior": {**prior, "noise": -1}}},
        {"trust": [1]},
        {"uncertainty": None},
    ):
        (tmp_path / "out.json").write_text(json.dumps({**whole, **damage}))
        files = FitFiles.around(tmp_path / "out.npz")
        assert files is not None
        with pytest.raises(CorruptFile, match=r"out\.json: 'trust' is damaged"):
            read_fit(files)
