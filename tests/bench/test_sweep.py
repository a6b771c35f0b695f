"""`brdfit bench sweep` on a toy population: what is run, on which materials, what is concluded."""

from __future__ import annotations

import argparse
import json

import numpy as np
import pytest

from brdfit.bench import sweep
from brdfit.bench.paper.reproduction import page as paper_page
from brdfit.bench.paper.settings import PaperSettings
from brdfit.bench.paper.summary import Summary
from brdfit.bench.questions import QUESTIONS, Question, Variant, contender, defaults, variants
from brdfit.bench.sweep import SweepSettings
from brdfit.bench.sweep_page import page
from brdfit.bench.tuning import tuning_materials, untouched_materials, used_materials
from brdfit.errors import UsageError
from brdfit.grid import Grid
from brdfit.progress import silent

TINY = SweepSettings(
    PaperSettings(
        universe=0.5,
        data_ratios=(0.5,),
        outlier_ratios=(0.0, 0.4),
        image_size=12,
        grid=Grid(18, 15, 20),
        parts=("errors",),
    ),
    materials=2,
    questions=(
        Question("gamma", "our", ({"gamma": 4.0}, {"gamma": 16.0}), ("log", "linear"), "Why."),
        Question("smoothing", "loc", ({"smoothing": 1e-2}, {"smoothing": 10.0})),
        Question("kernel", "tab", ({"kernel": "linear"}, {"kernel": "cubic"})),
    ),
)


@pytest.fixture
def tiny(monkeypatch, toy_population):
    monkeypatch.setattr(sweep, "_settings", lambda arguments: TINY)
    monkeypatch.setattr(sweep, "_population", lambda name: toy_population)
    # The code may be edited while a test runs; two runs are to be the same one all the same.
    monkeypatch.setattr(sweep, "versions", lambda: {"code": "0"})


def bench(*words):
    parser = argparse.ArgumentParser()
    sweep.add_arguments(parser)
    said = []
    sweep.run(parser.parse_args([str(word) for word in words]), silent, said.append)
    return said


def test_every_variant_is_run_once_on_tuning_materials_and_the_page_follows_from_the_result(
    tmp_path, tiny
):
    result, target = tmp_path / "sweep.json", tmp_path / "sweep.md"
    bench("-o", result, "--workers", 1)
    content = json.loads(result.read_text())
    records = content["records"]
    assert {record["material"] for record in records} == {"toy00", "toy06"}
    assert len(records) == (4 + 2 + 2) * 2 * 2
    assert all(np.isfinite(record["error"]) for record in records)
    text = target.read_text()
    assert "| default | 16.0 |" in text
    assert str(tmp_path) not in text + result.read_text()
    again = tmp_path / "again.json"
    bench("-o", again, "--workers", 2)
    assert again.read_bytes() == result.read_bytes()
    target.unlink()
    bench("-o", result, "--from-result")
    assert target.read_text() == text


def test_another_benchmarks_result_is_refused(tmp_path):
    other = tmp_path / "paper.json"
    other.write_text('{"benchmark": "paper", "records": []}')
    with pytest.raises(UsageError, match="not a result of `brdfit bench sweep`"):
        bench("-o", other, "--from-result")


def test_every_third_material_is_set_apart_and_the_others_are_untouched():
    names = [f"m{index:03d}" for index in range(100)]
    tuning = tuning_materials(reversed(names))
    assert tuning == names[::3]
    assert len(untouched_materials(names)) == 66
    assert sorted([*tuning, *untouched_materials(names)]) == names
    assert set(used_materials(names, 6)) < set(tuning)
    assert len(used_materials(names, 6)) == 6
    assert used_materials(names, 0) == tuning


def test_every_question_has_the_default_among_its_values():
    default = defaults(QUESTIONS)
    for question in QUESTIONS:
        plain = Variant(question.method, ())
        own = default[question.method]
        runs = [run for candidate in question.candidates for run in question.runs(candidate, own)]
        assert plain in runs, question.title


def test_a_variant_that_several_questions_ask_for_is_run_once():
    found = variants(QUESTIONS)
    assert len(set(found)) == len(found) == len({variant.key for variant in found})
    asked = sum(len(one.candidates) * max(len(one.metrics), 1) for one in QUESTIONS)
    assert len(found) < asked


def test_a_variant_has_the_settings_it_names():
    one = Variant.of("our", {"gamma": 4.0, "softening": 1.4}, defaults(QUESTIONS)["our"])
    assert one.key == "our|gamma=4.0"
    record = contender(one).record()
    assert record == {**defaults(QUESTIONS)["our"], "gamma": 4.0}


def made_up(errors):
    """Return a result in which smoothing 1 and 2 (the default) have these errors."""
    names = [f"m{index}" for index in range(9)]
    used = used_materials(names, 0)
    question = Question("smoothing", "loc", ({"smoothing": 1.0}, {"smoothing": 2.0}))
    return {
        "benchmark": "sweep",
        "command": "brdfit bench sweep",
        "settings": {
            "data_ratio": 0.1,
            "outlier_ratios": [0.0],
            "outliers": "factor",
            "seed": 1,
            "universe": 0.05,
        },
        "materials": {"all": names, "used": used},
        "population": {"name": "toy", "fingerprint": "0" * 64},
        "methods": {"loc": {"smoothing": 2.0, "error_metric": "log"}},
        "questions": [question.record()],
        "versions": {"code": "0"},
        "records": [
            {
                "variant": variant,
                "material": name,
                "outlier_ratio": 0.0,
                "samples": 10,
                "error": error,
            }
            for variant, row in errors.items()
            for name, error in zip(used, row, strict=True)
        ],
    }


@pytest.mark.parametrize(
    ("other", "told"),
    [
        ((1.0, 2.0, 3.1), "the default is smallest"),
        ((0.5, 1.5, 2.5), "clearly larger"),
        ((0.1, 1.0, 3.5), "not to be told from it"),
        ((0.9, None, 2.9), "the default is smallest"),
    ],
)
def test_the_page_says_how_the_default_stands(other, told):
    text = page(made_up({"loc|smoothing=1.0": other, "loc|default": (1.0, 2.0, 3.0)}))
    if told == "the default is smallest":
        assert "Smallest mean: smoothing 2.0, the default." in text
    else:
        assert "Smallest mean: smoothing 1.0. The default, smoothing 2.0, lies" in text
        assert f"above it: {told}." in text
    assert "**m0**, **m3**, **m6**" in text
    assert "the other\n6: m1, m2, m4, m5, m7, m8." in text


@pytest.mark.parametrize(("best", "told"), [(0, True), (1, False), (2, True)])
def test_the_page_warns_where_the_smallest_error_is_at_the_edge_of_what_was_tried(best, told):
    names = ("loc|smoothing=1.0", "loc|default", "loc|smoothing=3.0")
    content = made_up({name: (1.0 + (i != best),) * 3 for i, name in enumerate(names)})
    content["questions"][0]["candidates"] = [{"smoothing": value} for value in (1.0, 2.0, 3.0)]
    assert ("at the edge of what was tried (smoothing)" in page(content)) == told


def paper_content(materials):
    names = [f"m{index}" for index in range(9)]
    records = [
        {
            "part": "errors",
            "method": "our",
            "metric": "log",
            "samples": 10,
            "material": name,
            "data_ratio": data,
            "outlier_ratio": 0.0,
            "error": data * (5.0 if index % 3 == 0 else 2.0),
        }
        for index, name in enumerate(names)
        for data in (1.0, 0.1)
    ]
    return {
        "benchmark": "paper",
        "command": "brdfit bench paper",
        "settings": {
            "outliers": "factor",
            "seed": 1,
            "universe": 0.05,
            "grid": [90, 90, 180],
            "materials": materials,
            "data_ratios": [1.0, 0.1],
        },
        "population": {"name": "toy", "fingerprint": "0" * 64, "members": 9},
        "methods": {},
        "versions": {},
        "records": records,
    }


def test_the_paper_shows_the_mean_over_materials_that_no_constant_was_chosen_on():
    text = paper_page(paper_content(0), {})
    assert "| outliers | 9 materials | 6 materials |" in text
    assert "| 0.00 | 0.30 | 0.20 |" in text
    assert "no constant was chosen on" not in paper_page(paper_content(3), {})


def test_a_mean_may_be_taken_among_some_materials():
    summary = Summary(paper_content(0)["records"])
    assert summary.mean("our", 0.0, 1.0, ["m1", "m3"]) == pytest.approx(3.5)
    assert summary.mean("our", 0.0, 1.0, ["unknown"]) is None
