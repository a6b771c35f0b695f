"""The tables of few samples, and the posterior in the poster's tables."""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from brdfit.bench.paper import add_arguments, command, run
from brdfit.bench.paper.contender import ErrorWork
from brdfit.bench.paper.contenders import contenders_of
from brdfit.bench.paper.few import few_case, few_records, row_of
from brdfit.bench.paper.few_page import AIMS, few_blocks, posterior_blocks
from brdfit.bench.paper.posterior import KnownComponents
from brdfit.bench.paper.scene import Scene
from brdfit.bench.paper.settings import FEW_ROWS, PaperSettings
from brdfit.bench.paper.summary import Summary
from brdfit.bench.verdicts import deviation, judged
from brdfit.bench.workers import Task
from brdfit.errors import FitError, UsageError
from brdfit.grid import Grid
from brdfit.populations import Population
from brdfit.progress import silent
from brdfit.reconstruct import Posterior
from brdfit.reconstruct.posterior.principal import principal_basis
from brdfit.samples import Samples

TINY = PaperSettings(
    universe=0.3,
    few=((80, "factor"), (60, "uniform")),
    few_draws=2,
    outlier_ratios=(0.0, 0.4),
    materials=2,
    image_size=12,
    parts=("few",),
    grid=Grid(18, 15, 20),
)


@pytest.fixture
def tiny(monkeypatch, toy_population):
    monkeypatch.setattr(command, "_settings", lambda arguments: TINY)
    monkeypatch.setattr(command, "_population", lambda name: toy_population)
    monkeypatch.setattr(command, "versions", lambda: {"code": "0"})


@pytest.fixture(scope="module")
def scene(toy_population):
    return Scene.build(TINY, toy_population, silent)


def bench(*words):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    run(parser.parse_args([str(word) for word in words]), silent, lambda text: None)


def test_every_cell_has_a_record_and_the_page_the_aims(tmp_path, tiny):
    result = tmp_path / "few.json"
    bench("-o", result, "--methods", "glo", "post", "--workers", 1)
    records = json.loads(result.read_text())["records"]
    assert len(records) == 2 * 2 * 2 * 2
    assert {record["samples"] for record in records} == {60, 80}
    assert all(np.isfinite(record["error"]) for record in records)
    for record in records:
        assert ("precision" in record) == (record["method"] == "post")
        assert "seconds" not in record
    summary = Summary(records)
    spoilt = summary.few("post", (80, "factor"), 0.4)
    assert np.mean([record["recall"] for record in spoilt]) > 0.8
    assert np.mean([record["precision"] for record in spoilt]) > 0.8
    page = result.with_suffix(".md").read_text()
    assert "### 80 samples, `factor`" in page
    assert "| 80 factor | 0.4 |" in page
    timings = json.loads(result.with_suffix(".timings.json").read_text())
    assert set(timings["records"]) == {r["key"] for r in records if r["method"] == "post"}


def test_cells_and_outliers_do_not_depend_on_what_else_is_run(scene, toy_population):
    alone = Scene.build(replace(TINY, few=((60, "uniform"),)), toy_population, silent)
    case, other = (few_case(one, 2, 60) for one in (scene, alone))
    assert np.array_equal(scene.universe[case.rows], alone.universe[other.rows])
    one = scene.few(2, case.rows, "uniform", 0.4)
    assert np.array_equal(one.values, alone.few(2, other.rows, "uniform", 0.4).values)
    assert one.mask.sum() == 24
    assert not np.array_equal(one.mask, scene.few(2, case.rows, "factor", 0.4).mask)


def test_draws_lie_behind_a_universe_that_they_do_not_change(scene, toy_population):
    plain = Scene.build(replace(TINY, parts=("errors",)), toy_population, silent)
    assert np.array_equal(scene.rows(0.5), plain.rows(0.5))
    assert np.array_equal(scene.universe[scene.rows(1.0)], plain.universe)
    assert few_case(scene, 0, 60).draw != few_case(scene, 1, 60).draw
    assert np.isin(scene.universe, TINY.grid.cells).all()


@dataclass(frozen=True)
class Lacking:
    """The toy's source without one of its members."""

    whole: Population
    gone: int
    name: str = "lacking"
    bilateral: bool = True
    channels: tuple[str, ...] = ("R", "G", "B")
    fingerprint: str = "1" * 64

    @property
    def members(self):
        return tuple(name for i, name in enumerate(self.whole.members) if i != self.gone)

    @property
    def materials(self):
        return self.members

    def evaluate(self, wi, wo, pick):
        kept = np.delete(np.arange(len(self.whole)), self.gone)
        return self.whole.source.evaluate(wi, wo, kept[np.asarray(pick)])


def test_the_posterior_leaves_out_as_if_the_material_had_never_been_there(scene, toy_population):
    case = few_case(scene, 2, 80)
    values = scene.few(2, case.rows, "factor", 0.2).values
    contender = contenders_of(toy_population)["post"]
    found = contender.reconstruct(scene, contender.prepare(scene, case), case, values)
    wi, wo = scene.directions(case.rows)
    lacking = Posterior(population=Population.of(Lacking(toy_population, 2)))
    result = lacking.fit(Samples(wi=wi, wo=wo, value=values, channels=("R", "G", "B")))
    expected = result.evaluate(*scene.target)
    assert np.median(np.abs(np.log(found.values / expected))) < 1e-2
    assert np.mean(found.named == result.outliers) > 0.95


def test_components_are_looked_up_where_known_and_asked_for_elsewhere(scene, toy_population):
    basis = principal_basis(toy_population)
    known = KnownComponents.of(basis, scene)
    wi, wo = scene.directions(scene.rows(1.0)[::7])
    assert np.allclose(known.at(wi, wo), basis.at(wi, wo), atol=1e-4)
    # where theta_d = 0 several cells have one direction: any of their rows is an answer, and
    # a product may round them differently
    alone = ~np.isclose(wi, wo, rtol=0.0, atol=1e-9).all(axis=1)
    assert alone.sum() > 100
    assert np.array_equal(known.at(wi, wo)[alone], known.components[scene.rows(1.0)[::7]][alone])
    assert np.array_equal(known.at(wo, wi), basis.at(wo, wi))


def test_precision_and_recall_are_shares_of_what_was_named_and_of_what_was_moved_far():
    clean = np.full((8, 2), 0.5)
    spoilt = clean.copy()
    spoilt[:3] *= np.array([[4.0], [2.0], [1.01]])
    moved = deviation(clean, spoilt)
    assert np.allclose(moved[:4], [np.log(4.0), np.log(2.0), np.log(1.01), 0.0])
    planted = np.arange(8) < 3
    named = np.isin(np.arange(8), [0, 2, 5])
    found = judged(named, planted, moved, noise=0.1)
    assert found["recall"] == 0.5
    assert np.isclose(found["precision"], 2 / 3, rtol=1e-5)
    assert found["flagged"] == 0.375
    nobody = judged(named, np.zeros(8, dtype=bool), moved, 0.1)
    assert nobody["precision"] is nobody["recall"] is None
    assert nobody["flagged"] == 0.375


def test_the_posterior_is_held_against_the_best_of_the_others():
    def record(method, material, error):
        cell = {"part": "errors", "outlier_ratio": 0.2, "data_ratio": 0.1}
        return {**cell, "method": method, "material": material, "error": error}

    errors = [("post", 0.1), ("glo", 0.3), ("tab", 0.2)]
    blocks = posterior_blocks(Summary([record(name, "a", error) for name, error in errors]))
    assert "1 of 1" in blocks[1]
    assert "**0.100 / 0.200 Tab**" in blocks[2]
    assert posterior_blocks(Summary([record("glo", "a", 0.3)])) == []


def test_a_refused_fit_leaves_its_reason_and_no_mean(scene):
    class Refuses:
        metric = None

        def share(self, case):
            return case.places

        def prepare(self, scene, case):
            return None

        def reconstruct(self, scene, prepared, case, values):
            raise FitError("not these")

    work = ErrorWork(scene, {"glo": Refuses()})
    records = few_records(work, Task("", ("few", "glo", 0, TINY.few)))
    assert {record["refused"] for record in records} == {"FitError: not these"}
    assert "| Glo | - | - |" in "".join(few_blocks(Summary(records), {}))


def test_rows_are_read_as_they_are_written_and_refused_in_words():
    assert row_of("1000:factor") == (1000, "factor")
    assert set(AIMS) == set(FEW_ROWS)
    for row in ((0, "factor"), (10, "typo"), (10**7, "factor")):
        with pytest.raises(UsageError, match="number of samples"):
            PaperSettings(few=(row,))
    with pytest.raises(SystemExit):
        bench("--rows", "thousand")
