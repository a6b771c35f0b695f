"""From a name to a population, and the upkeep that the command line offers."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.errors import PopulationError
from brdfit.grid import Grid
from brdfit.populations import Population, check, clear, columns, list_populations, population
from brdfit.populations.fetch import fetched_path
from brdfit.populations.store import MANIFEST

SMALL = Grid(6, 6, 8)
Toy = Callable[..., Any]


def test_the_front_door_of_the_package_is_this_one() -> None:
    assert brdfit.population is population
    assert len(brdfit.population("published")) == 200


def test_a_population_is_returned_as_it_is() -> None:
    some = population("published").without(["chrome"])
    assert population(some) is some


def test_a_misspelt_name_is_corrected() -> None:
    with pytest.raises(
        PopulationError, match=r"There are published, synthetic, .*mean 'published'\?"
    ):
        population("publishd")


def test_a_path_that_does_not_exist_lists_what_there_is(tmp_path: Path) -> None:
    with pytest.raises(PopulationError, match="neither a population of that name nor a file"):
        population(tmp_path / "nothing.zip")


def test_networks_that_were_not_fetched_say_how(cache: Path) -> None:
    with pytest.raises(PopulationError, match="brdfit basis fetch nbrdf"):
        population("nbrdf")


def test_merl_by_name_says_its_terms_and_asks_for_the_folder(cache: Path) -> None:
    with pytest.raises(PopulationError, match="give the path of their folder"):
        population("merl")


def test_fetched_networks_answer_to_their_name(cache: Path, shared_data: Path) -> None:
    archive = shared_data / "nbrdf" / "merl_nbrdf.zip"
    fetched_path("nbrdf").write_bytes(archive.read_bytes())
    assert len(population("nbrdf")) == 100
    assert population("nbrdf").fingerprint == population(archive).fingerprint
    nbrdf = next(info for info in list_populations() if info.name == "nbrdf")
    assert nbrdf.available
    assert check("nbrdf").ok


def test_the_list_says_what_is_ready_and_what_to_do(cache: Path) -> None:
    infos = {info.name: info for info in list_populations()}
    assert set(infos) == {"published", "synthetic", "embedded", "nbrdf", "merl"}
    assert infos["published"].available
    assert not infos["published"].built
    assert not infos["nbrdf"].available
    assert infos["nbrdf"].advice == "brdfit basis fetch nbrdf"
    assert "terms" in infos["merl"].advice


def test_published_is_in_order(cache: Path) -> None:
    report = check("published")
    assert report.ok
    assert [finding.subject for finding in report.findings] == ["members", "cached columns"]


def test_networks_that_are_missing_are_reported_not_raised(cache: Path) -> None:
    report = check("nbrdf")
    assert not report.ok
    assert report.findings[0].verdict == "missing"


def test_a_damaged_archive_is_reported_not_raised(cache: Path) -> None:
    pytest.importorskip("h5py")
    fetched_path("nbrdf").write_bytes(b"nothing good")
    assert check("nbrdf").findings[0].verdict == "damaged"
    assert not next(info for info in list_populations() if info.name == "nbrdf").available


def test_clearing_removes_what_was_computed_but_not_what_was_fetched(cache: Path, toy: Toy) -> None:
    built = columns(Population.of(toy()), SMALL)
    brdfit.populations.remember("toy", "key", lambda: {"x": np.zeros(3)})
    fetched_path("nbrdf").write_bytes(b"kept")
    cleared = clear()
    assert cleared.entries == 2
    assert cleared.bytes > 0
    assert not built.store.folder.exists()
    assert fetched_path("nbrdf").exists()


def test_only_stale_columns_are_cleared_if_asked(cache: Path, toy: Toy) -> None:
    current = columns(population("published"), Grid(3, 3, 2)).store.folder
    old = columns(Population.of(toy()), SMALL).store.folder
    manifest = json.loads((old / MANIFEST).read_text())
    assert clear(stale_only=True).entries == 0
    manifest["source"] = "published"
    (old / MANIFEST).write_text(json.dumps(manifest))
    (cache / "columns" / ".left-over.part").mkdir()
    assert clear(stale_only=True).entries == 2
    assert current.exists()
    assert not old.exists()
