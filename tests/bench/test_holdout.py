"""`brdfit bench holdout` on made-up files: what is split, compared, counted and written."""

from __future__ import annotations

import argparse
import json

import numpy as np
import pytest

from brdfit.bench import holdout
from brdfit.bench.holdout.page import page
from brdfit.bench.options import write_page
from brdfit.bench.real_files import Split, compare, find_cases, split
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical
from brdfit.progress import silent
from brdfit.samples import Samples

DIRECTIONS = 205


@pytest.fixture
def folder(tmp_path, rng):
    """Two smooth materials in CUReT's layout; one value of the second is at the noise floor."""
    data = tmp_path / "data" / "curet"
    data.mkdir(parents=True)
    theta = rng.uniform(0.05, 1.2, (2, DIRECTIONS))
    phi = rng.uniform(-np.pi, np.pi, (2, DIRECTIONS))
    rows = np.stack([theta[0], phi[0], theta[1], phi[1]], axis=1)
    lines = [" ".join([str(i + 1), *(f"{x:.6f}" for x in row)]) for i, row in enumerate(rows)]
    (data / "table.txt").write_text("\n".join(lines) + "\n")
    wi = directions_from_spherical(theta[1], phi[1])
    wo = directions_from_spherical(theta[0], phi[0])
    values = [0.2 + 0.1 * wi[:, 2] * wo[:, 2], 0.1 + 0.3 * (wi[:, 2] + wo[:, 2])]
    values[1][7] = 0.0
    lines = [" ".join([str(i + 1), *(f"{x:.6f}" for x in v)]) for i, v in enumerate(values)]
    (data / "made_up.dat").write_text("\n".join(lines) + "\n")
    return tmp_path / "data"


def bench(*words):
    parser = argparse.ArgumentParser()
    holdout.add_arguments(parser)
    said = []
    holdout.run(parser.parse_args([str(word) for word in words]), silent, said.append)
    return said


def test_every_material_and_method_has_a_record_and_a_place_in_the_table(tmp_path, folder):
    result = tmp_path / "out.json"
    words = ("--methods", "local", "log_rbf", "--conditions", "share")
    bench("--data", folder, "-o", result, *words, "--workers", 1)
    content = json.loads(result.read_text())
    records = {record["key"]: record for record in content["records"]}
    assert set(records) == {
        f"curet/made_up.dat#{material}|share|{method}"
        for material in ("01", "02")
        for method in ("local", "log_rbf")
    }
    for record in records.values():
        assert record["fitted"] == 41
        assert record["compared"] + record["censored"] == record["held_out"] == 164
        assert 0.0 < record["mean"] < 0.1
    assert {"curet/made_up.dat", "curet/table.txt"} == set(content["inputs"])
    page = result.with_suffix(".md").read_text()
    result.with_suffix(".md").unlink()
    bench("-o", result, "--from-result")
    assert result.with_suffix(".md").read_text() == page
    assert "| curet/made_up.dat#02 |" in page
    assert "| local | log_rbf |" in page
    assert str(tmp_path) not in page + result.read_text()


def test_the_result_does_not_depend_on_the_workers(tmp_path, folder):
    for workers in (1, 2):
        words = ("--methods", "local", "log_rbf", "--conditions", "100", "--workers", workers)
        bench("--data", folder, "-o", tmp_path / f"{workers}.json", *words)
    assert (tmp_path / "1.json").read_bytes() == (tmp_path / "2.json").read_bytes()


def test_an_unknown_method_names_the_known_ones(tmp_path, folder):
    with pytest.raises(UsageError, match="log_rbf"):
        bench("--data", folder, "-o", tmp_path / "x.json", "--methods", "typo")


def test_a_folder_without_measurements_says_what_was_looked_for(tmp_path):
    with pytest.raises(UsageError, match=r"cornell/\*\.astm"):
        find_cases(tmp_path)


@pytest.fixture
def samples(random_directions):
    wi, wo = random_directions(50)
    value = np.linspace(-0.02, 1.0, 50)
    value[40] = np.nan
    return Samples(wi=wi, wo=wo, value=value)


def test_what_is_fitted_and_what_is_held_out_share_nothing_and_leave_out_only_the_unusable(
    samples,
):
    fitted, held_out = split(samples, Split(0.2, 1), "name")
    assert (len(fitted), len(held_out)) == (10, 39)
    both = np.concatenate([fitted.value[:, 0], held_out.value[:, 0]])
    assert np.array_equal(np.sort(both), np.delete(np.linspace(-0.02, 1.0, 50), 40))
    again, _ = split(samples, Split(0.2, 1), "name")
    assert np.array_equal(again.value, fitted.value)
    other, _ = split(samples, Split(0.2, 2), "name")
    assert not np.array_equal(other.value, fitted.value)


def test_only_positive_values_are_compared_and_the_others_are_counted(samples):
    predicted = np.full((50, 1), 0.5)
    predicted[10] = -1.0
    found = compare(samples, predicted)
    positive = np.delete(samples.value[:, 0], [10, 40])
    positive = positive[positive > 0.0]
    assert found["compared"] == positive.size
    assert found["without_prediction"] == 1
    assert found["censored"] == int((samples.value[:, 0] <= 0.0).sum())
    assert found["missing"] == 1
    assert np.isclose(found["mean"], np.abs(np.log(0.5 / positive)).mean(), rtol=1e-5)


def test_a_result_of_an_earlier_version_is_named_as_one(tmp_path):
    result = tmp_path / "old.json"
    result.write_text('{"benchmark": "holdout", "records": []}')
    with pytest.raises(UsageError, match=r"old\.json: found no .* Run the benchmark again"):
        write_page(result, "holdout", page, lambda text: None)
    assert not result.with_suffix(".md").exists()
