"""`brdfit bench speed` at a tiny size: floors, stages that do what they say, ledger, page."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

import numpy as np
import pytest

from brdfit.bench.speed import add_arguments, command, run
from brdfit.bench.speed.command import measure_stage
from brdfit.bench.speed.job import Job, Sizes
from brdfit.bench.speed.machine import Floor, Machine
from brdfit.bench.speed.measure import Prepared, measured, watched_peak
from brdfit.bench.speed.page import page
from brdfit.bench.speed.stages import JOB, STAGES
from brdfit.bench.workers import in_own_process
from brdfit.errors import MissingExtra, UsageError
from brdfit.grid import Grid
from brdfit.progress import silent

TINY = Sizes(30, 5, 40, 50, 6, 12, 8, Grid(10, 8, 12))
FIGURES = {"times", "median", "processor", "peak_mb", "added_mb", "bandwidth", "single", "double"}
FIGURES |= {"load"}
BESIDE = {"bytes", "memory_floor", "product_floor", "floor", "over_floor", "over_memory"}


@pytest.fixture
def job(tmp_path, toy_population):
    return Job(toy_population, 1, TINY, tmp_path)


@pytest.fixture
def slow_machine(monkeypatch):
    machine = Machine(bandwidth=1e9, single=2e9, double=1e9)
    monkeypatch.setattr(Machine, "measured", lambda: machine)
    return machine


@pytest.fixture
def tiny(monkeypatch, toy_population, slow_machine):
    """The command at a tiny size, in this process."""

    def shrunk(lean_on, seed, sizes, folder, measured):
        return Job(toy_population, seed, TINY, folder, measured)

    monkeypatch.setattr(command, "Job", shrunk)
    monkeypatch.setattr(command, "in_own_process", lambda function, *rest: function(*rest))
    # The code may be edited while a test runs; two runs are to be the same one all the same.
    monkeypatch.setattr(command, "versions", lambda: {"code": "0"})


def bench(*words):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    said = []
    run(parser.parse_args([str(word) for word in words]), silent, said.append)
    return said


def test_a_floor_is_the_longer_of_moving_and_computing(slow_machine):
    assert Floor(2_000_000_000, single=1e9).seconds(slow_machine) == 2.0
    assert Floor(10, single=2e9, double=3e9).seconds(slow_machine) == 4.0


def test_rates_are_operations_and_bytes_a_second():
    machine = Machine.measured(block=1 << 20, edge=64)
    assert machine.bandwidth > 1e6
    assert machine.single > 1e6
    assert machine.double > 1e6


def test_memory_that_a_run_takes_is_seen():
    before, peak = watched_peak()
    # large enough to come from the system, not from what the process has freed before
    block = np.ones(100_000_000, dtype=np.uint8)
    assert peak() >= before + block.nbytes * 0.9


def test_a_stage_is_run_as_often_as_was_said_and_judged_by_its_last_result(slow_machine):
    calls = []

    def work():
        calls.append(len(calls))
        return calls[-1]

    prepared = Prepared(work, Floor(1000), count=4, judge=lambda last: {"last": last})
    record = measured(prepared, repeat=3)
    assert calls == [0, 1, 2, 3]
    assert len(record["times"]) == 3
    assert record["last"] == 3
    assert record["memory_floor"] == record["floor"] == 1e-6
    assert record["over_floor"] == pytest.approx(record["median"] / 1e-6, rel=1e-3)
    assert measured(Prepared(work), repeat=1, warm=False).keys() == FIGURES


@pytest.mark.parametrize("name", list(STAGES))
def test_every_stage_states_its_figures(name, job, slow_machine):
    if name == "job_sklearn_gp":
        pytest.importorskip("sklearn", reason="scikit-learn is not installed (extra 'rivals')")
    record = measure_stage(job, name)
    whole = name.startswith("job_")
    assert record.keys() >= FIGURES | (set() if whole else BESIDE)
    assert len(record["times"]) == STAGES[name].repeat
    if whole:
        assert record["cells"] == TINY.grid.cells.size
        assert 0.0 < record["error"] < 2.0
    if name.startswith("batch_"):
        assert record["items"] == TINY.items


def test_a_dense_table_reads_the_components_and_writes_every_cell(job):
    prepared = STAGES["dense_rgb"].prepare(job)
    table = prepared.run()
    assert table.missing == 0
    assert prepared.floor.moved > table.values.nbytes


def test_a_preview_counts_the_directions_that_it_asks_for(job):
    prepared = STAGES["preview"].prepare(job)
    assert prepared.run().shape == (TINY.picture, TINY.picture, 3)
    assert prepared.floor.moved == prepared.told["directions"] * 8 * 3 * 4


def test_what_is_written_is_read(job):
    samples = STAGES["read_csv"].prepare(job).run()
    assert len(samples) == TINY.many
    STAGES["write_bsdf"].prepare(job).run()
    assert (job.folder / "written.bsdf").stat().st_size > 0


def test_measurements_are_spoilt_but_of_the_material_and_the_fits_do_not_lean_on_it(job):
    samples = job.samples(TINY.few)
    assert job.material not in job.others.unique_materials
    cells = TINY.grid.cells
    near = {tuple(np.round(row, 9)): i for i, row in enumerate(TINY.grid.directions(cells)[0])}
    assert all(tuple(np.round(row, 9)) in near for row in samples.wi)
    assert np.array_equal(samples.value, job.samples(TINY.few).value)
    assert job.spectral().value.shape == (TINY.band_samples, TINY.bands)
    shared, own = job.items(shared=True), job.items(shared=False)
    assert all(np.array_equal(shared[0].wi, item.wi) for item in shared)
    assert not np.array_equal(own[0].wi, own[1].wi)


def test_the_ridge_loop_fits_each_item(job):
    result = STAGES["batch_ridge_loop"].prepare(job).run()
    assert result.shape[::2] == (TINY.items, 3)
    assert np.isfinite(result).all()


def test_the_ledger_holds_a_record_a_stage_and_the_page_tells_of_each(tmp_path, tiny, monkeypatch):
    result = tmp_path / "speed.json"
    words = ("-o", result, "--stages", "dense_rgb", "preview", "batch_own", JOB)
    load = iter((0.5, 7.0))  # of the two runs: it is no part of what a run is
    monkeypatch.setattr(os, "getloadavg", lambda: (next(load, 7.0), 0.0, 0.0))
    said = bench(*words)
    content = json.loads(result.read_text())
    stages = [record["stage"] for record in content["records"]]
    assert stages == ["batch_own", "dense_rgb", "preview", JOB]
    assert content["machine"]["cpus"] == os.cpu_count()
    assert content["command"].startswith("brdfit bench speed --population embedded --stages")
    text = result.with_suffix(".md").read_text()
    assert all(what in text for what in content["settings"]["stages"].values())
    assert "at most 2.5" in text
    assert "at least 50" in text
    assert any("wrote" in line for line in said)
    assert any("complete already" in line for line in bench(*words))


def test_a_killed_run_goes_on_where_it_was(tmp_path, tiny, monkeypatch):
    words = ("-o", tmp_path / "speed.json", "--stages", "preview", "read_csv")
    seen = []

    def dies(job, name):
        seen.append(name)
        if name == "preview":
            raise KeyboardInterrupt
        return measure_stage(job, name)

    monkeypatch.setattr(command, "measure_stage", dies)
    with pytest.raises(KeyboardInterrupt):
        bench(*words)
    monkeypatch.setattr(command, "measure_stage", measure_stage)
    said = bench(*words)
    assert seen == ["read_csv", "preview"]
    assert said[0].startswith("continuing: 1 of 2")


def test_a_rival_whose_package_is_missing_is_left_out_and_said_to_be(tmp_path, tiny, monkeypatch):
    def missing(samples, grid):
        raise MissingExtra("scikit-learn", "rivals", "the rival")

    monkeypatch.setattr("brdfit.bench.speed.rivals.gaussian_process", missing)
    result = tmp_path / "speed.json"
    bench("-o", result, "--stages", "job_sklearn_gp", JOB)
    record = json.loads(result.read_text())["records"][-1]
    assert "brdfit[rivals]" in record["left_out"]
    assert "## Left out" in page(json.loads(result.read_text()))


def test_a_mistyped_stage_is_named_with_those_that_are_known(tmp_path):
    with pytest.raises(UsageError, match=r"'dense_rbg' but known are read_csv, fit_posterior"):
        bench("-o", tmp_path / "speed.json", "--stages", "dense_rbg")


def test_a_file_of_each_laboratory_is_read_besides(tmp_path, tiny, shared_data):
    result = tmp_path / "speed.json"
    bench("-o", result, "--data", shared_data, "--stages", "read_cornell")
    content = json.loads(result.read_text())
    assert content["records"][0]["samples"] > 1000
    assert any(name.startswith("cornell/") for name in content["inputs"])


def test_a_part_runs_in_another_process_and_its_error_is_raised_here():
    assert in_own_process(os.getpid) != os.getpid()
    with pytest.raises(FileNotFoundError):
        in_own_process(os.stat, str(Path("no such file")))
