"""What comes out of a store is what single fits give, and what failed is said."""

from __future__ import annotations

import numpy as np
import pytest
from small_batch import N_SAMPLES, columns, method

from brdfit.batch import open_batch, open_input, run_batch
from brdfit.cli import main
from brdfit.errors import FitError, UsageError
from brdfit.formats import read_samples, read_table, write_samples
from brdfit.grid import Grid
from brdfit.samples import Samples

pytest.importorskip("zarr", reason="stores need zarr: pip install 'brdfit[batch]'")


def sample_of(item, named):
    rows = slice(item * N_SAMPLES, (item + 1) * N_SAMPLES)
    wi, wo = (np.stack([named[f"{w}_{a}"][rows] for a in "xyz"], axis=1) for w in ("wi", "wo"))
    return Samples(wi=wi, wo=wo, value=np.stack([named[c][rows] for c in "RGB"], axis=1))


def test_an_item_is_its_single_fit(store, random_directions):
    where, named = random_directions(200), columns(700)
    batch = open_batch(store)
    assert len(batch) == batch.done == 700
    for number in (0, 63, 64, 699):
        item, single = batch[number], method().fit(sample_of(number, named))
        assert np.allclose(
            np.log(item.evaluate(*where)), np.log(single.evaluate(*where)), atol=1e-5
        )
        assert item.outcome is single.outcome
        assert batch.column("outliers")[number] == single.outliers.sum()
        assert batch.column("noise")[number] == pytest.approx(single.history[0]["noise"], rel=1e-5)
        assert batch.column("samples")[number] == N_SAMPLES
        assert batch.column("position")[number].tolist() == [number % 16, number // 16]


def test_items_answer_to_number_and_name(store):
    batch = open_batch(store)
    assert batch["17"].index == batch[17].index == batch[-683].index == 17
    assert batch.names[17] == "17"
    assert "700 items" in repr(batch)
    with pytest.raises(UsageError, match="no item 'brass'"):
        batch["brass"]
    with pytest.raises(UsageError, match="there are 700"):
        batch[700]


def test_the_table_of_an_item_is_its_function(store):
    grid = Grid(9, 8, 12)
    item = open_batch(store)[3]
    table = item.table(grid)
    values = item.evaluate(*grid.directions(grid.cells))
    assert np.allclose(table.values.reshape(-1, 3)[grid.cells], values, rtol=1e-5)
    assert (item.evaluate([[0.0, 0.0, -1.0]], [[0.0, 0.0, 1.0]]) == 0.0).all()


@pytest.fixture
def archive(tmp_path):
    """Return a folder of four files: two good, one broken, one of other channels."""
    folder = tmp_path / "archive"
    (folder / "deep").mkdir(parents=True)
    named = columns(3)
    for number in range(2):
        write_samples(sample_of(number, named), folder / f"good{number}.csv")
    mono = sample_of(2, named).select_channels([1])
    write_samples(mono, folder / "mono.parquet")
    (folder / "deep" / "broken.parquet").write_bytes(b"PAR1 and no more")
    return folder


def test_a_bad_file_is_recorded_and_the_rest_go_on(tmp_path, archive, random_directions):
    summary = run_batch(open_input(archive), tmp_path / "a.zarr", method())
    assert dict(summary.failed).keys() == {"deep/broken.parquet", "mono.parquet"}
    assert "cannot be read" in dict(summary.failed)["deep/broken.parquet"]
    assert "other channels" not in dict(summary.failed)["mono.parquet"]
    assert "found channels" in dict(summary.failed)["mono.parquet"]
    batch = open_batch(tmp_path / "a.zarr")
    where = random_directions(50)
    single = method().fit(read_samples(archive / "good1.csv"))
    found = batch["good1.csv"].evaluate(*where)
    assert np.allclose(np.log(found), np.log(single.evaluate(*where)), atol=1e-5)
    with pytest.raises(FitError, match=r"mono\.parquet.*found channels"):
        batch["mono.parquet"]
    assert [item.name for item in batch] == ["good0.csv", "good1.csv"]


@pytest.fixture
def program(monkeypatch, capsys):
    """Return a function that runs the program, whose populations are small, and what it said."""
    small = method().population
    monkeypatch.setattr("brdfit.reconstruct.compact.method.population", lambda name: small)

    def run(*words):
        code = main([str(word) for word in words])
        return code, *capsys.readouterr()

    return run


def test_the_program_fits_continues_and_hands_out_items(tmp_path, table, program):
    out, item = tmp_path / "p.zarr", tmp_path / "i.npz"
    words = ("batch", table, "-o", out, "--components", 12, "--workers", 2)
    code, said, _ = program(*words)
    assert code == 0
    assert "700 items of about 24 samples" in said
    assert "fitted 700 items" in said
    assert "nothing left to do" in program(*words)[1]
    assert program("convert", f"{out}#5", item)[0] == 0
    assert np.allclose(read_table(item).values, open_batch(out)[5].table().values, equal_nan=True)
    code, _, errors = program("convert", out, item)
    assert code == 2
    assert "name one of them" in errors
    code, _, errors = program("convert", f"{out}#brass", item)
    assert code == 2
    assert "no item 'brass'" in errors


def test_the_program_says_what_failed_and_what_was_mistyped(tmp_path, archive, program):
    code, said, errors = program("batch", archive, "-o", tmp_path / "a.zarr", "--workers", 1)
    assert code == 0
    assert "2   failed" in said
    assert "deep/broken.parquet" in errors
    code, _, errors = program("batch", archive, "-o", tmp_path / "b.zarr", "--memory", "much")
    assert code == 2
    assert "such as 800MB" in errors
    code, _, errors = program("batch", archive, "-o", tmp_path / "b.zarr", "--item", "a")
    assert code == 2
    assert "one long table" in errors
