"""Parts of real files: spoilt, blind, too small; intervals, and what was to be reached."""

from __future__ import annotations

import argparse

import numpy as np
import pytest

from brdfit.bench.holdout import add_arguments, run
from brdfit.bench.holdout.aims import Cells, aims_table
from brdfit.bench.holdout.command import _chosen_methods
from brdfit.bench.holdout.conditions import part_of
from brdfit.bench.holdout.judgement import judge_method
from brdfit.bench.holdout.seen import SEEN, unseen
from brdfit.bench.real_files import Split, find_cases, input_hashes
from brdfit.errors import UsageError
from brdfit.geometry import directions_from_spherical, spherical_from_directions
from brdfit.progress import silent
from brdfit.reconstruct import LocalBasis, Posterior
from brdfit.samples import Samples

HOW = Split(0.2, 1)


def samples_at(theta_i, rng):
    """Smooth and positive, one row an incidence angle (degrees), anywhere in wo."""
    n = len(theta_i)
    wi = directions_from_spherical(np.radians(theta_i), rng.uniform(0.0, 2 * np.pi, n))
    wo = directions_from_spherical(rng.uniform(0.0, 1.3, n), rng.uniform(0.0, 2 * np.pi, n))
    return Samples(wi=wi, wo=wo, value=0.2 + 0.1 * wi[:, 2] * wo[:, 2])


@pytest.fixture
def samples(rng):
    return samples_at(rng.uniform(0.0, 75.0, 300), rng)


def test_so_many_are_fitted_and_outliers_are_planted_among_the_same(samples):
    clean, spoilt = (part_of("a", samples, name, HOW) for name in ("100", "100:factor"))
    assert len(clean.fitted) == len(spoilt.fitted) == 100
    assert len(clean.held_out) == 200
    assert np.array_equal(clean.fitted.wi, spoilt.fitted.wi)
    assert np.array_equal(clean.held_out.value, spoilt.held_out.value)
    assert spoilt.planted.sum() == 30
    same = (clean.fitted.value == spoilt.fitted.value).all(axis=1)
    assert np.array_equal(same, ~spoilt.planted)
    assert np.array_equal(spoilt.moved > 0.0, spoilt.planted)
    assert not clean.planted.any()


def test_a_condition_that_a_file_is_too_small_for_does_not_apply(samples):
    assert part_of("a", samples, "240", HOW) is not None
    assert part_of("a", samples, "241", HOW) is None
    with pytest.raises(UsageError, match="1000:factor"):
        part_of("a", samples, "100:typo", HOW)
    with pytest.raises(UsageError, match="blind"):
        part_of("a", samples, "typo", HOW)


@pytest.mark.parametrize("angles", [(0.0, 15.0, 30.0, 45.0, 60.0), (10.0, 50.0), None])
def test_blind_regions_are_whole_angles_and_none_of_them_is_fitted(angles, rng, samples):
    if angles is not None:
        samples = samples_at(rng.choice(angles, 300), rng)
    part = part_of("a", samples, "blind", HOW)
    fitted, held_out = (
        np.round(np.degrees(spherical_from_directions(one.wi)[0]))
        for one in (part.fitted, part.held_out)
    )
    if angles is not None:
        assert not set(fitted) & set(held_out)
    assert held_out.max() > fitted.max() - 1.0
    assert 0.3 < len(held_out) / len(samples) < 0.7
    if angles is None:
        # the second of four bands, with fitted angles on both sides
        inside = held_out < np.median(held_out)
        assert fitted.min() < held_out[inside].min()
        assert fitted.max() > held_out[inside].max()


def test_one_incidence_angle_leaves_nothing_to_be_blind_to(rng):
    assert part_of("a", samples_at(np.full(50, 30.0), rng), "blind", HOW) is None


def test_intervals_hold_what_they_promise_where_the_noise_is_normal(rng, toy_population):
    clean = samples_at(rng.uniform(0.0, 75.0, 700), rng)
    noise = rng.normal(0.0, 0.05, clean.value.shape)
    samples = clean.with_value(clean.value * np.exp(noise))
    part = part_of("a", samples, "500", HOW)
    record = judge_method(Posterior(population=toy_population, residual_size=100), part)
    assert abs(record["within_68"] - 0.68) < 0.12
    assert abs(record["within_95"] - 0.95) < 0.05
    assert abs(record["noise"] - 0.05) < 0.015
    assert record["flagged"] < 0.03
    assert "within_68" not in judge_method(LocalBasis(), part)


def test_a_blank_counts_among_the_inputs(tmp_path):
    folder = tmp_path / "rt300s"
    folder.mkdir()
    for name in ("blank_1.xls", "paint.xls"):
        (folder / name).write_text(name)
    cases = find_cases(tmp_path)
    assert [case.name for case in cases] == ["rt300s/paint.xls"]
    assert set(input_hashes(cases)) == {"rt300s/blank_1.xls", "rt300s/paint.xls"}


def record(condition, file, method, mean):
    return {"condition": condition, "file": file, "method": method, "mean": mean}


def test_aims_are_quotients_of_means_and_the_worst_file():
    records = [
        *(record("100", file, "log_rbf", mean) for file, mean in (("a", 0.2), ("b", 0.1))),
        *(record("100", file, "global", mean) for file, mean in (("a", 0.1), ("b", 0.3))),
        *(record("100", file, "posterior", mean) for file, mean in (("a", 0.11), ("b", 0.05))),
    ]
    lines = aims_table(Cells(records), ["posterior"]).splitlines()
    assert lines[2].endswith("| at most 0.88 | **0.800** |")
    assert lines[3].endswith("| at most 1.03 | 1.100 |")
    assert lines[4].endswith("| - |")


def test_files_that_constants_were_chosen_on_are_told_apart():
    files = (min(SEEN), "rgl/another.bsdf")
    errors = dict(zip(files, (0.05, 0.2), strict=True))
    records = [record("100", file, "posterior", mean) for file, mean in errors.items()]
    records += [record("100", file, name, 0.1) for file in files for name in ("log_rbf", "global")]
    every = Cells(records)
    assert aims_table(every, ["posterior"]).splitlines()[2].endswith("| 1.250 |")
    assert aims_table(unseen(every), ["posterior"]).splitlines()[2].endswith("| 2.000 |")


def test_populations_are_named_behind_a_colon_and_files_by_a_part_of_their_name(tmp_path, rng):
    data = tmp_path / "curet"
    data.mkdir()
    theta, phi = rng.uniform(0.05, 1.2, (2, 60)), rng.uniform(-np.pi, np.pi, (2, 60))
    rows = np.stack([theta[0], phi[0], theta[1], phi[1]], axis=1)
    lines = [" ".join([str(i + 1), *(f"{x:.6f}" for x in row)]) for i, row in enumerate(rows)]
    (data / "table.txt").write_text("\n".join(lines) + "\n")
    (data / "x.dat").write_text("1 " + " ".join(["0.2"] * 60) + "\n")
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    words = ["--data", tmp_path, "-o", tmp_path / "o.json", "--workers", 1]
    words += ["--conditions", "share", "--methods", "global:published", "local"]
    settings = parser.parse_args([str(word) for word in [*words, "--files", "nothing"]])
    with pytest.raises(UsageError, match="curet/x"):
        run(settings, silent, lambda text: None)
    settings = parser.parse_args([str(word) for word in [*words, "--methods", "local:x"]])
    with pytest.raises(UsageError, match="NAME:POPULATION"):
        run(settings, silent, lambda text: None)
    assert _chosen_methods(["global:embedded"])["global:embedded"].population == "embedded"
