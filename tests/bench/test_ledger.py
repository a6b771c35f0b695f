"""A run that is killed and continued ends with the bytes of an undisturbed one."""

from __future__ import annotations

import collections
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from brdfit.bench.ledger import Journal, Ledger, code_fingerprint, figure, read_result
from brdfit.bench.workers import Task
from brdfit.errors import CorruptFile, UsageError

SCRIPT = Path(__file__).with_name("run_a_ledger.py")
HEADER = {"benchmark": "test", "settings": {"seed": 1}}


def command(result, *options):
    log = result.with_suffix(".log")
    return [sys.executable, str(SCRIPT), str(result), str(log), *options]


def run(result, *options):
    return subprocess.run(command(result, *options), capture_output=True, text=True, timeout=60)


def run_and_signal(result, number, entries):
    """Start the run, wait until the journal has that many lines, send the signal."""
    process = subprocess.Popen(command(result), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    journal = result.with_suffix(".journal.jsonl")
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and process.poll() is None:
        if journal.exists() and journal.read_bytes().count(b"\n") >= entries:
            break
        time.sleep(0.002)
    process.send_signal(number)
    process.communicate(timeout=30)
    return process.returncode


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    result = tmp_path_factory.mktemp("undisturbed") / "out.json"
    done = run(result)
    assert done.returncode == 0, done.stderr
    return result.read_bytes()


def test_a_run_killed_at_random_moments_ends_with_the_same_bytes(tmp_path, undisturbed):
    result = tmp_path / "out.json"
    journal = result.with_suffix(".journal.jsonl")
    moments = sorted(random.Random(7).sample(range(2, 55), 4))
    kept = []
    for entries in moments:
        assert run_and_signal(result, signal.SIGKILL, entries) == -signal.SIGKILL
        assert not result.exists()
        kept.append([json.loads(line)["task"] for line in journal.read_bytes().split(b"\n")[1:-1]])
    assert run(result).returncode == 0
    assert result.read_bytes() == undisturbed
    assert not journal.exists()
    # What was in the journal when the last kill came was not done again.
    times = collections.Counter(result.with_suffix(".log").read_text().split())
    assert all(times[key] == 1 for key in kept[0])
    assert len(kept[-1]) > len(kept[0])


def test_an_interrupt_keeps_what_is_finished(tmp_path, undisturbed):
    result = tmp_path / "out.json"
    assert run_and_signal(result, signal.SIGINT, 10) != 0
    assert result.with_suffix(".journal.jsonl").read_bytes().count(b"\n") >= 10
    done = run(result)
    assert "continuing" in done.stdout
    assert result.read_bytes() == undisturbed


def test_the_death_of_a_worker_is_reported_and_survived(tmp_path, undisturbed):
    result = tmp_path / "out.json"
    died = run(result, "--fatal", "task040")
    assert died.returncode != 0
    assert "worker process of the benchmark died" in died.stderr
    assert run(result).returncode == 0
    assert result.read_bytes() == undisturbed


def test_an_unfinished_run_of_other_settings_is_refused_and_restart_is_the_way_out(tmp_path):
    result = tmp_path / "out.json"
    run_and_signal(result, signal.SIGKILL, 5)
    refused = run(result, "--gain", "2")
    assert refused.returncode != 0
    assert "settings.gain (1.0, now 2.0)" in refused.stderr
    assert run(result, "--gain", "2", "--restart").returncode == 0
    assert read_result(result)["settings"] == {"gain": 2.0}


def square(shared, task):
    if task.payload == shared:
        raise ValueError("no square")
    return [{"key": task.key, "value": figure(task.payload**2)}]


TASKS = [Task(f"t{number}", number) for number in range(12)]


def test_a_finished_run_is_not_done_again(tmp_path):
    ledger = Ledger(tmp_path / "out.json", HEADER, workers=1)
    first = ledger.run(TASKS, square, lambda left: None)

    def never(left):
        raise AssertionError("prepared although nothing is left")

    assert ledger.run(TASKS, square, never) == first


def test_a_finished_result_of_other_settings_is_replaced(tmp_path):
    Ledger(tmp_path / "out.json", HEADER, workers=1).run(TASKS[:2], square, lambda left: None)
    other = Ledger(tmp_path / "out.json", {"benchmark": "other"}, workers=1)
    assert len(other.run(TASKS, square, lambda left: None)) == 12
    assert read_result(tmp_path / "out.json")["benchmark"] == "other"


def test_the_number_of_workers_and_the_order_of_tasks_do_not_change_the_result(tmp_path):
    one, two = tmp_path / "one.json", tmp_path / "two.json"
    Ledger(one, HEADER, workers=1).run(TASKS, square, lambda left: None)
    Ledger(two, HEADER, workers=2).run(TASKS[::-1], square, lambda left: None)
    assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_in_a_task_names_the_task_and_keeps_the_others(tmp_path, workers):
    ledger = Ledger(tmp_path / "out.json", HEADER, workers=workers)
    with pytest.raises(ValueError, match="no square") as caught:
        ledger.run(TASKS, square, lambda left: 11)
    assert "t11" in caught.value.__notes__[0]
    left = []
    ledger.run(TASKS, square, lambda todo: left.extend(task.key for task in todo))
    assert "t11" in left
    assert len(left) < 12


def test_a_torn_last_line_is_cut_off(tmp_path):
    path = tmp_path / "j.jsonl"
    with Journal(path, HEADER) as journal:
        journal.append("a", [{"key": "a"}], 0.1)
        journal.append("b", [{"key": "b"}], 0.1)
    whole = path.read_bytes()
    for torn in (whole[:-1], whole[:-9], whole + b'{"task": "c", "rec', whole[:-9] + b"\0\n"):
        path.write_bytes(torn)
        with Journal(path, HEADER) as journal:
            assert "a" in journal.done
            assert "c" not in journal.done
            journal.append("b", [{"key": "b"}], 0.1)
        assert path.read_bytes().startswith(whole[: whole.index(b'"b"') - 30])
        with Journal(path, HEADER) as journal:
            assert set(journal.done) == {"a", "b"}


def test_a_journal_torn_in_its_header_starts_afresh(tmp_path):
    path = tmp_path / "j.jsonl"
    path.write_bytes(b'{"header": {"bench')
    with Journal(path, HEADER) as journal:
        assert journal.done == {}
    assert json.loads(path.read_bytes())["header"] == HEADER


def test_damage_in_the_middle_of_a_journal_is_an_error_that_names_the_line(tmp_path):
    path = tmp_path / "j.jsonl"
    with Journal(path, HEADER) as journal:
        journal.append("a", [], 0.1)
        journal.append("b", [], 0.1)
    lines = path.read_bytes().split(b"\n")
    path.write_bytes(b"\n".join([lines[0], b"garbage", lines[2], b""]))
    with pytest.raises(CorruptFile, match="line 2 of 3"):
        Journal(path, HEADER)


def test_tasks_of_the_same_key_are_refused(tmp_path):
    with pytest.raises(UsageError, match="same key"):
        Ledger(tmp_path / "out.json", HEADER).run([Task("a"), Task("a")], square, lambda left: None)


def test_a_result_holds_no_times(tmp_path):
    ledger = Ledger(tmp_path / "out.json", HEADER, workers=1)
    ledger.run(TASKS, square, lambda left: None)
    assert "seconds" not in ledger.result.read_text()
    assert set(json.loads(ledger.timings_path.read_text())["seconds"]) == {t.key for t in TASKS}
    assert sorted(os.listdir(tmp_path)) == ["out.json", "out.timings.json"]


def test_progress_counts_from_zero_to_all_and_starts_where_the_journal_ends(tmp_path):
    seen = []
    ledger = Ledger(tmp_path / "out.json", HEADER, workers=1)
    with pytest.raises(ValueError, match="no square"):
        ledger.run(TASKS, square, lambda left: 5)
    ledger.run(TASKS, square, lambda left: None, lambda label, done, total: seen.append(done))
    assert seen == [0, *range(5, 13)]


def test_figures_are_rounded_and_what_is_not_finite_becomes_null():
    assert figure(1.0 / 3.0) == 0.333333
    assert figure(123456789.0) == 123457000.0
    assert figure(float("nan")) is None


def test_the_code_fingerprint_is_stable():
    assert code_fingerprint() == code_fingerprint()
    assert len(code_fingerprint()) == 16
