"""`brdfit bench paper` on a toy population: result, tables, figures, and running it again."""

from __future__ import annotations

import argparse
import json

import numpy as np
import pytest

from brdfit.bench.paper import add_arguments, command, parts, run
from brdfit.bench.paper.contender import Case
from brdfit.bench.paper.contenders import contenders_of, methods_of
from brdfit.bench.paper.poster import DATA_RATIOS, ERRORS, OUTLIER_RATIOS, REAL, REAL_AVERAGE
from brdfit.bench.paper.scene import Scene
from brdfit.bench.paper.settings import PaperSettings
from brdfit.bench.paper.summary import Summary
from brdfit.errors import UsageError
from brdfit.grid import Grid
from brdfit.progress import silent
from brdfit.reconstruct import PcaRidge
from brdfit.samples import Samples

TINY = PaperSettings(
    universe=0.5,
    data_ratios=(1.0, 0.3),
    outlier_ratios=(0.0, 0.4),
    materials=2,
    image_size=12,
    parts=("errors", "sensitivity", "expressiveness"),
    grid=Grid(18, 15, 20),
)


@pytest.fixture
def tiny(monkeypatch, toy_population):
    monkeypatch.setattr(command, "_settings", lambda arguments: TINY)
    monkeypatch.setattr(command, "_population", lambda name: toy_population)
    # The code may be edited while a test runs; two runs are to be the same one all the same.
    monkeypatch.setattr(command, "versions", lambda: {"code": "0"})


def bench(*words):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    said = []
    run(parser.parse_args([str(word) for word in words]), silent, said.append)
    return said


def test_every_table_and_figure_is_made_and_running_again_changes_nothing(
    tmp_path, tiny, monkeypatch
):
    result, page = tmp_path / "paper.json", tmp_path / "docs" / "page.md"
    page.parent.mkdir()
    poster = ("--methods", "our", "glo", "loc", "tab")
    bench("-o", result, "--docs", page, "--workers", 1, *poster)
    content = json.loads(result.read_text())
    summary = Summary(content["records"])
    assert summary.methods("errors") == ["our", "glo", "loc", "tab"]
    assert len(summary.part("errors")) == 4 * 2 * 2 * 2
    assert all(np.isfinite(record["error"]) for record in summary.part("errors"))
    assert set(summary.sensitivity("our")) == {"linear", "root", "log"}
    assert summary.expressiveness().size == 2
    figures = {path.name for path in (tmp_path / "paper").iterdir()}
    assert figures == {"heat_maps.png", "outliers.png", "worst.png"}
    text = page.read_text()
    assert "(../paper/heat_maps.png)" in text
    assert str(tmp_path) not in text
    for name in ("heat_maps", "outlier_curves", "worst_spheres"):
        monkeypatch.setattr(parts, name, lambda *_: None)
    before = result.read_bytes(), text
    assert "complete already" in bench("-o", result, "--docs", page, "--workers", 2, *poster)[0]
    assert (result.read_bytes(), page.read_text()) == before
    page.unlink()
    bench("-o", result, "--docs", page, "--from-result")
    assert page.read_text() == text


def test_two_workers_give_the_bytes_of_one(tmp_path, tiny):
    for workers in (1, 2):
        bench("-o", tmp_path / f"{workers}.json", "--workers", workers, "--methods", "glo", "loc")
    assert (tmp_path / "1.json").read_bytes() == (tmp_path / "2.json").read_bytes()


def test_columns_that_the_poster_lacks_are_there_when_asked_for(tmp_path, tiny):
    result = tmp_path / "x.json"
    bench("-o", result, "--methods", "glo", "pca", "--parts", "errors", "--workers", 1)
    content = json.loads(result.read_text())
    assert Summary(content["records"]).methods("errors") == ["glo", "pca"]
    assert "### pca" in result.with_suffix(".md").read_text()


def test_fewer_samples_than_columns_use_the_first_components(scene, toy_population):
    case = Case(2, 0.3, scene.rows(0.3)[::60])
    assert case.rows.size < 18
    values = scene.measured(2, case.rows, 0.3, 0.0).values
    contender = contenders_of(toy_population)["pca"]
    fast = contender.reconstruct(scene, contender.prepare(scene, case), case, values).values
    wi, wo = scene.directions(case.rows)
    method = PcaRidge(population=toy_population.without(["toy02"]))
    result = method.fit(Samples(wi=wi, wo=wo, value=values))
    slow = result.evaluate(*scene.target)
    seen = (slow > 1e-4).all(axis=1)
    # the axes come from other cells
    assert np.median(np.abs(np.log(fast[seen] / slow[seen]))) < 0.02


def test_an_unknown_column_names_the_known_ones(tmp_path, tiny):
    with pytest.raises(UsageError, match="our, glo, loc, tab, pca, post"):
        bench("-o", tmp_path / "x.json", "--methods", "typo")


def test_the_real_table_without_a_folder_is_refused(tmp_path):
    with pytest.raises(UsageError, match="--data"):
        bench("-o", tmp_path / "x.json", "--parts", "real")


@pytest.fixture(scope="module")
def scene(toy_population):
    return Scene.build(TINY, toy_population, silent)


@pytest.mark.parametrize(
    "name", ["glo", "glo:linear", "glo:root", "loc", "loc:root", "tab", "pca", "post"]
)
def test_a_column_says_what_the_method_itself_says(name, scene, toy_population):
    subject, others = 2, toy_population.without(["toy02"])
    case = Case(subject, 0.3, scene.rows(0.3))
    values = scene.measured(subject, case.rows, 0.3, 0.4).values
    contender = contenders_of(toy_population)[name]
    fast = contender.reconstruct(scene, contender.prepare(scene, case), case, values).values
    settings = {} if ":" not in name else {"error_metric": name.split(":")[1]}
    if name.startswith(("glo", "pca", "post")):
        settings["population"] = others
    method = type(methods_of(others)[name.split(":")[0]])(**settings)
    wi, wo = scene.directions(case.rows)
    result = method.fit(Samples(wi=wi, wo=wo, value=values))
    slow = result.evaluate(*scene.target)
    seen = (slow > 0.0).all(axis=1)
    assert seen.mean() > 0.99
    assert np.allclose(np.log(fast[seen]), np.log(slow[seen]), atol=2e-3)


def test_a_correction_starts_from_the_others_only(scene, toy_population):
    """The material's own column is made worthless: nothing may change."""
    contender, case = contenders_of(toy_population)["our"], Case(2, 0.3, scene.rows(0.3))
    values = scene.measured(2, case.rows, 0.3, 0.2).values
    expected = contender.reconstruct(scene, contender.prepare(scene, case), case, values).values
    other = Scene.build(TINY, toy_population, silent)
    for name in ("at_universe", "at_target"):
        spoilt = getattr(other, name).copy()
        spoilt[:, :, 2] = np.random.default_rng(0).normal(size=spoilt.shape[:2])
        object.__setattr__(other, name, spoilt)
    fresh = contenders_of(toy_population)["our"]
    assert np.array_equal(
        fresh.reconstruct(other, fresh.prepare(other, case), case, values).values, expected
    )


def test_the_posters_tables_are_whole():
    assert all(len(rows) == len(OUTLIER_RATIOS) for rows in ERRORS.values())
    assert all(len(row) == len(DATA_RATIOS) for rows in ERRORS.values() for row in rows)
    for name, values in REAL.items():
        assert len(values) == 16
        assert abs(np.mean(values) - REAL_AVERAGE[name]) < 0.006
