"""A run may be killed, lose its workers or be told nonsense: the store is the same, or refused."""

from __future__ import annotations

import dataclasses
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from small_batch import BLOCK, Deadly, columns, content, method, write_parquet, write_zarr

from brdfit.batch import open_batch, open_input, run_batch
from brdfit.batch.engine import Processes, Work
from brdfit.batch.run import items_of_a_block
from brdfit.errors import CorruptFile, FitError, SampleError, UsageError

pytest.importorskip("zarr", reason="stores need zarr: pip install 'brdfit[batch]'")

SCRIPT = Path(__file__).with_name("small_batch.py")
BLOCKS = 11


def start(table, store, workers):
    words = [sys.executable, str(SCRIPT), str(table), str(store), str(workers)]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def done(store):
    return len(list((store / "done" / "c").glob("[0-9]*"))) if store.exists() else 0


# --- killed and continued ------------------------------------------------------------------


@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_killed_at_random_moments_and_continued_is_the_undisturbed_one(
    tmp_path, table, store, workers
):
    path, chance = tmp_path / "out.zarr", random.Random(workers)
    for least in sorted(chance.sample(range(BLOCKS), 3)):
        process = start(table, path, workers)
        while done(path) < least and process.poll() is None:
            time.sleep(0.002)
        time.sleep(chance.uniform(0.0, 0.05))
        process.kill()
        process.communicate()
    last = start(table, path, workers)
    assert last.communicate()[1] == ""
    assert last.returncode == 0
    assert content(path) == content(store)


def test_what_is_done_is_not_done_again(tmp_path, table):
    path, told = tmp_path / "out.zarr", []

    def stop_after_four(result):
        told.append(result.start)
        if len(told) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_batch(open_input(table), path, method(), block=BLOCK, told=stop_after_four)
    summary = run_batch(open_input(table), path, method(), block=BLOCK, told=stop_after_four)
    assert summary.continued
    assert summary.fitted == 700 - 4 * BLOCK
    assert sorted(told) == list(range(0, 700, BLOCK))


def test_remains_of_a_killed_writer_are_removed(tmp_path, table, store):
    path = tmp_path / "out.zarr"
    run_batch(open_input(table), path, method(), block=BLOCK)
    (path / "noise" / "c" / "0.abc.partial").write_bytes(b"half")
    (path / "done" / "c" / "0").unlink()
    run_batch(open_input(table), path, method(), block=BLOCK)
    assert content(path) == content(store)


def test_a_worker_that_dies_costs_nothing(tmp_path, table, store):
    path, killed = tmp_path / "out.zarr", []

    def kill_one(result):
        if not killed:
            killed.append(multiprocessing.active_children()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    run_batch(open_input(table), path, method(), block=BLOCK, engine=Processes(2), told=kill_one)
    assert killed
    assert content(path) == content(store)


def test_a_task_that_kills_every_worker_ends_the_run_in_words_and_keeps_the_rest(tmp_path, table):
    path = tmp_path / "out.zarr"
    deadly = Deadly(open_input(table))
    with pytest.raises(FitError, match="died 4 times over items 128 to 191"):
        run_batch(deadly, path, method(), block=BLOCK, engine=Processes(2))
    assert 0 < open_batch(path).done < 700


def test_two_runs_do_not_write_the_same_store(tmp_path, table):
    path = tmp_path / "out.zarr"

    def another(result):
        with pytest.raises(UsageError, match="another brdfit batch"):
            run_batch(open_input(table), path, method(), block=BLOCK)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_batch(open_input(table), path, method(), block=BLOCK, told=another)


# --- inputs --------------------------------------------------------------------------------


def test_parquet_and_zarr_are_the_same_table(tmp_path):
    named = columns(150, shared=False)
    found = [
        open_input(write_parquet(tmp_path / "a.parquet", named)),
        open_input(write_zarr(tmp_path / "a.zarr", named)),
    ]
    for start_, stop in ((0, 150), (64, 128), (149, 150), (5, 71)):
        one, other = (source.part(start_, stop) for source in found)
        assert one.names == other.names == [str(i) for i in range(start_, stop)]
        assert np.array_equal(one.block.samples.value, other.block.samples.value)
        assert np.array_equal(one.block.starts, other.block.starts)
        assert np.array_equal(one.position[:, 0], np.arange(start_, stop) % 16)
        assert one.block.samples.channels == ("R", "G", "B")
        rows = slice(start_ * 24, stop * 24)
        assert np.array_equal(one.block.samples.value[:, 0], named["R"][rows])


def test_items_may_have_names_and_any_number_of_rows(tmp_path):
    named = columns(3, shared=False)
    lengths = [10, 50, 12]
    named["item"] = np.repeat(["brass", "blue paint", "ä"], lengths)
    source = open_input(write_parquet(tmp_path / "a.parquet", named))
    part = source.part(0, 3)
    assert part.names == ["brass", "blue paint", "ä"]
    assert np.diff(part.block.starts).tolist() == lengths
    assert source.longest_name == len("blue paint")


def test_scattered_rows_are_refused_with_what_to_do(tmp_path):
    named = columns(4)
    named["item"] = named["item"] % 2
    with pytest.raises(SampleError, match="Sort the table by 'item'"):
        open_input(write_parquet(tmp_path / "a.parquet", named))


def test_a_table_without_items_or_values_says_what_is_missing(tmp_path):
    named = columns(4)
    named["point"] = named.pop("item")
    assert open_input(write_parquet(tmp_path / "b.parquet", named)).count == 4
    named["which"] = named.pop("point")
    path = write_parquet(tmp_path / "a.parquet", named)
    with pytest.raises(UsageError, match="--item COLUMN"):
        open_input(path)
    assert open_input(path, item="which").count == 4
    with pytest.raises(UsageError, match="no column 'where'"):
        open_input(path, item="where")
    del named["G"], named["R"]
    with pytest.raises(UsageError, match="values"):
        open_input(write_parquet(tmp_path / "c.parquet", named), item="which")


def test_a_damaged_table_and_an_empty_place_are_named(tmp_path, table):
    (tmp_path / "a.parquet").write_bytes(table.read_bytes()[:5000])
    with pytest.raises(CorruptFile, match=r"a\.parquet"):
        open_input(tmp_path / "a.parquet")
    with pytest.raises(UsageError, match="found no file"):
        open_input(tmp_path / "nowhere")


def test_another_input_or_setting_is_not_mixed_in(tmp_path, table, store):
    other = write_parquet(tmp_path / "patch.parquet", columns(700, seed=1))
    before = content(store)
    with pytest.raises(UsageError, match="input"):
        run_batch(open_input(other), store, method())
    with pytest.raises(UsageError, match="method"):
        run_batch(open_input(table), store, dataclasses.replace(method(), steps=5))
    assert content(store) == before


def test_a_folder_that_is_no_store_is_left_alone(tmp_path, table):
    path = write_zarr(tmp_path / "mine.zarr", {"a": np.arange(3)})
    for restart in (False, True):
        with pytest.raises(UsageError, match="not one that brdfit batch wrote"):
            run_batch(open_input(table), path, method(), restart=restart)
    assert (path / "a").is_dir()


def test_memory_decides_how_many_items_are_held(table):
    source = open_input(table)
    small, large = (items_of_a_block(source, size << 20, 2) for size in (700, 4000))
    assert 0 < small <= large
    with pytest.raises(UsageError, match="fewer workers"):
        items_of_a_block(source, 100 << 20, 2)


def test_the_work_of_a_part_hangs_on_the_part_alone(table):
    source, kind = open_input(table), method()
    work = Work(source, kind, kind.basis(), 3)
    one, again = work.do((0, 64, 128)), work.do((0, 64, 128))
    assert all(np.array_equal(one.arrays[n], again.arrays[n], equal_nan=True) for n in one.arrays)
