"""`brdfit bench sparse` on a toy population: directions, split, records, page."""

from __future__ import annotations

import argparse
import json

import numpy as np
import pytest

from brdfit.bench.sparse import add_arguments, command, run
from brdfit.bench.sparse.cases import IMAGE_METRICS, Scene, SparseSettings, draw_directions
from brdfit.bench.sparse.page import means, page
from brdfit.bench.sparse.published import HELD_OUT, HYPERBRDF, SAMPLES
from brdfit.errors import FitError, PopulationError, UsageError
from brdfit.geometry import half_diff_from_directions
from brdfit.progress import silent
from brdfit.reconstruct import METHODS, PcaRidge, Tabulated

TOY_HELD_OUT = ("toy01", "toy05")


@pytest.fixture
def tiny(monkeypatch, toy_population):
    def settings(seed, samples, repeats):
        return SparseSettings(seed, samples, repeats, TOY_HELD_OUT, image_size=12)

    monkeypatch.setattr(command, "SparseSettings", settings)
    monkeypatch.setattr(settings, "repeats", 1, raising=False)
    monkeypatch.setattr(command, "HELD_OUT", TOY_HELD_OUT)
    monkeypatch.setattr(command, "_population", lambda name: toy_population)
    # The code may be edited while a test runs; two runs are to be the same one all the same.
    monkeypatch.setattr(command, "versions", lambda: {"code": "0"})


def bench(*words):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    said = []
    run(parser.parse_args([str(word) for word in words]), silent, said.append)
    return said


def test_every_case_has_a_record_and_the_page_the_published_figures(tmp_path, tiny):
    result = tmp_path / "sparse.json"
    words = ("-o", result, "--samples", 40, 8, "--repeats", 2, "--workers", 1)
    bench(*words, "--methods", "pca_ridge", "tabulated")
    content = json.loads(result.read_text())
    assert [record["key"] for record in content["records"]] == [
        f"{method}|{material}|n{count:05d}|r{repeat}"
        for method in ("pca_ridge", "tabulated")
        for material in TOY_HELD_OUT
        for count in (8, 40)
        for repeat in (0, 1)
    ]
    for record in content["records"]:
        assert all(np.isfinite(record[metric]) for metric in IMAGE_METRICS)
    assert content["lean_on"]["members"] == 5
    page = result.with_suffix(".md").read_text()
    assert "| N | pca_ridge | tabulated | HyperBRDF, MERL | HyperBRDF, MERL+RGL |" in page
    assert "| 3.189 | 3.112 |" in page
    assert str(tmp_path) not in page + result.read_text()
    said = bench(*words, "--methods", "pca_ridge", "tabulated")
    assert "complete already" in said[0]
    result.with_suffix(".md").unlink()
    bench("-o", result, "--from-result")
    assert result.with_suffix(".md").read_text() == page


def test_two_workers_give_the_bytes_of_one(tmp_path, tiny):
    for workers in (1, 2):
        words = ("--samples", 8, "--repeats", 1, "--methods", "global", "tabulated")
        bench("-o", tmp_path / f"{workers}.json", *words, "--workers", workers)
    assert (tmp_path / "1.json").read_bytes() == (tmp_path / "2.json").read_bytes()


def test_the_posterior_is_held_against_what_it_is_to_reach():
    cell = dict.fromkeys(IMAGE_METRICS, 0.5) | {"samples": 40, "material": "a", "repeat": 0}
    records = [
        cell | {"method": "pca_ridge", "perceptual_error": 1.0},
        cell | {"method": "posterior", "perceptual_error": 1.2},
    ]
    known = {"name": "p", "members": 2, "fingerprint": "0"}
    settings = {"samples": [40], "held_out": ["a"], "repeats": 1, "image_size": 12, "seed": 1}
    content = {"records": records, "settings": settings, "population": known, "lean_on": known}
    content |= {"methods": {"pca_ridge": {}, "posterior": {}}, "command": "", "versions": {}}
    assert "| 40 | 1.200 | **0.376** |" in page(content)
    del content["methods"]["posterior"]
    assert "to reach" not in page(content)


def test_every_method_runs_unless_some_are_named(toy_population):
    assert set(command.methods_of(toy_population)) == set(METHODS)
    assert set(command.methods_of(toy_population, ["pca_ridge"])) == {"pca_ridge"}
    with pytest.raises(UsageError, match="tabulated"):
        command.methods_of(toy_population, ["typo"])


def test_nothing_is_learnt_from_what_is_held_out(toy_population):
    left = command._without_held_out(toy_population, TOY_HELD_OUT)
    assert not set(left.materials) & set(TOY_HELD_OUT)
    assert len(left) == 5
    with pytest.raises(PopulationError, match="lacks 20 of the 20"):
        command._only_held_out(toy_population, HELD_OUT)


@pytest.fixture
def scene(toy_population):
    settings = SparseSettings(samples=(8, 60), repeats=1, held_out=TOY_HELD_OUT, image_size=16)
    methods = {
        "pca_ridge": PcaRidge(toy_population, eta=1e-9, epsilon=1e-6),
        "tabulated": Tabulated(),
    }
    return Scene(settings, toy_population, methods)


def test_a_method_that_knows_the_material_is_nearly_perfect(scene):
    many = scene.records("pca_ridge", "toy01")[-1]
    assert many["perceptual_error"] < 0.05
    assert many["psnr"] > 50.0
    assert many["ssim"] > 0.999


def test_a_refused_fit_leaves_its_reason_and_no_mean(scene):
    class Refuses:
        name = "refuses"

        def fit(self, samples):
            if len(samples) < 60:
                raise FitError("too few for this one")
            return Tabulated().fit(samples)

    scene.methods["refuses"] = Refuses()
    few, many = scene.records("refuses", "toy05")
    assert few["how"] == "FitError: too few for this one"
    assert few["psnr"] is None
    found = means([few, many])
    assert ("refuses", 8, "psnr") not in found
    assert found["refuses", 60, "psnr"] == many["psnr"]


def test_fewer_samples_are_the_beginning_of_more(scene):
    samples = scene.measure("toy01", 0)
    assert len(samples) == 60
    wi, wo = draw_directions(8, np.random.default_rng(3))
    more = draw_directions(5000, np.random.default_rng(3))
    assert np.array_equal(more[0][:8], wi)
    assert np.array_equal(more[1][:8], wo)
    assert not np.array_equal(samples.wi, scene.measure("toy05", 0).wi)
    assert not np.array_equal(samples.wi, scene.measure("toy01", 1).wi)


def test_directions_are_uniform_over_the_angles_that_are_above_the_horizon(rng):
    wi, wo = draw_directions(100_000, rng)
    assert (wi[:, 2] > 0.0).all()
    assert (wo[:, 2] > 0.0).all()
    theta_h, theta_d, phi_d = half_diff_from_directions(wi, wo)
    # where phi_d = pi/2 the horizon cuts next to nothing off
    inside = np.abs(phi_d - np.pi / 2) < 0.02
    for angle in (theta_h, theta_d):
        share, _ = np.histogram(angle[inside], bins=3, range=(0.0, np.pi / 2))
        assert np.allclose(share / inside.sum(), 1 / 3, atol=0.05)
    assert phi_d.max() < np.pi + 1e-9


def test_the_published_split_and_figures_are_whole():
    assert len(set(HELD_OUT)) == 20
    assert list(HELD_OUT) == sorted(HELD_OUT)
    for column in HYPERBRDF.values():
        assert set(column) < set(SAMPLES)
        assert all(set(cell) == set(IMAGE_METRICS) for cell in column.values())
