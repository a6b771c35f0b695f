"""Columns on disk: what they hold, when they are built, and what spoils them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from brdfit.errors import PopulationError, UsageError
from brdfit.grid import MERL_GRID, Grid
from brdfit.populations import Population, building, columns, population
from brdfit.populations.store import Store, intact, stored_cells

SMALL = Grid(12, 10, 16)
Toy = Callable[..., Any]


def test_columns_are_the_logarithms_of_the_members(cache: Path) -> None:
    some = population("published").subset(["steel", "pvc", "alum-bronze/abc"])
    found = columns(some, SMALL)
    wi, wo = SMALL.directions(found.cells)
    expected = some.log_values(wi, wo)
    for channel in range(3):
        np.testing.assert_array_equal(found.load(channel), expected[:, :, channel])


@pytest.mark.parametrize("grid", [SMALL, Grid(7, 6, 9), Grid(5, 5, 2)], ids=str)
def test_half_the_azimuths_of_a_bilateral_source_say_it_all(
    cache: Path, grid: Grid, toy: Toy
) -> None:
    toys = Population.of(toy())
    found = columns(toys, grid)
    everywhere = toys.log_values(*grid.directions(grid.cells))[:, :, 0]
    np.testing.assert_allclose(found.load(0)[found.expand], everywhere, atol=1e-5)
    assert found.multiplicity.sum() == grid.cells.size
    assert set(found.multiplicity) <= {1, 2}


def test_a_source_that_is_not_bilateral_has_all_cells(cache: Path, toy: Toy) -> None:
    found = columns(Population.of(toy(bilateral=False)), SMALL)
    np.testing.assert_array_equal(found.cells, SMALL.cells)
    np.testing.assert_array_equal(found.cells[found.expand], SMALL.cells)


def test_stored_cells_of_the_merl_grid_are_about_half() -> None:
    cells, expand = stored_cells(MERL_GRID, True)
    assert cells.size == 562_508
    assert expand.size == MERL_GRID.cells.size
    i, j, k = np.unravel_index(MERL_GRID.cells, MERL_GRID.shape)
    mirrored = np.ravel_multi_index((i, j, np.minimum(k, (180 - k) % 180)), MERL_GRID.shape)
    np.testing.assert_array_equal(cells[expand], mirrored)


def test_blocks_and_rows_are_parts_of_the_whole(cache: Path, toy: Toy) -> None:
    found = columns(Population.of(toy()), SMALL)
    whole = found.load(1)
    np.testing.assert_array_equal(found.block(1, 5, 40), whole[5:40])
    np.testing.assert_array_equal(found.block(1, len(found) - 3, len(found) + 99), whole[-3:])
    index = np.array([7, 3, len(found) - 1, 3, 0])
    np.testing.assert_array_equal(found.rows(1, index), whole[index])
    assert found.rows(1, np.array([], dtype=int)).shape == (0, 3)
    assert found.block(1, 0, 10).flags.c_contiguous


def test_a_selection_reads_the_same_files(cache: Path, toy: Toy) -> None:
    source = toy()
    everything = Population.of(source)
    whole = columns(everything, SMALL)
    asked = len(source.asked)
    some = columns(everything.without(["alpha 0.2"]), SMALL)
    assert len(source.asked) == asked
    np.testing.assert_array_equal(some.load(2), whole.load(2)[:, [0, 2]])
    np.testing.assert_array_equal(some.rows(2, np.array([9, 4])), whole.load(2)[[9, 4]][:, [0, 2]])


def test_a_row_or_channel_that_does_not_exist_is_named(cache: Path, toy: Toy) -> None:
    found = columns(Population.of(toy()), SMALL)
    with pytest.raises(UsageError, match=f"there are {len(found)} rows"):
        found.rows(0, np.array([len(found)]))
    with pytest.raises(UsageError, match="channel 3"):
        found.block(3, 0, 1)


def test_columns_are_built_once(cache: Path, toy: Toy) -> None:
    first, second = toy(), toy()
    columns(Population.of(first), SMALL)
    columns(Population.of(second), SMALL)
    assert first.asked
    assert not second.asked


def test_other_content_has_other_columns(cache: Path, toy: Toy) -> None:
    first, second = toy(), toy(alphas=(0.3, 0.5, 0.6), fingerprint="toy-2")
    one = columns(Population.of(first), SMALL).load(0)
    other = columns(Population.of(second), SMALL).load(0)
    assert second.asked
    assert not np.array_equal(one, other)


def _change_a_byte(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[100] ^= 0xFF
    path.write_bytes(content)
    os.utime(path, ns=(1, 1))


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-4])


@pytest.mark.parametrize("name", ["G.f32", "manifest.json"])
@pytest.mark.parametrize("spoil", [_change_a_byte, _cut, Path.unlink])
def test_damaged_columns_are_built_again(
    cache: Path, toy: Toy, name: str, spoil: Callable[[Path], None]
) -> None:
    whole = columns(Population.of(toy()), SMALL)
    good = whole.load(1)
    spoil(whole.store.folder / name)
    again = toy()
    np.testing.assert_array_equal(columns(Population.of(again), SMALL).load(1), good)
    assert again.asked


def test_columns_that_were_copied_are_trusted_after_a_look(cache: Path, toy: Toy) -> None:
    built = columns(Population.of(toy()), SMALL)
    os.utime(built.store.path(0), ns=(1, 1))
    again = toy()
    columns(Population.of(again), SMALL)
    assert not again.asked


def test_columns_removed_while_in_use_say_so(cache: Path, toy: Toy) -> None:
    found = columns(Population.of(toy()), SMALL)
    found.store.path(0).unlink()
    with pytest.raises(PopulationError, match="were removed while in use"):
        found.block(0, 0, 5)


def test_progress_goes_from_nothing_to_all(cache: Path, toy: Toy) -> None:
    heard: list[tuple[str, int, int]] = []
    columns(Population.of(toy()), SMALL, lambda *event: heard.append(event))
    assert heard[0][1] == 0
    assert heard[-1][1] == heard[-1][2] > 0
    assert "toy" in heard[0][0]


def test_an_interrupted_build_leaves_nothing(cache: Path, toy: Toy) -> None:
    def interrupt(label: str, done: int, total: int) -> None:
        if done:
            raise KeyboardInterrupt

    source = toy()
    with pytest.raises(KeyboardInterrupt):
        columns(Population.of(source), SMALL, interrupt)
    assert not [path for path in (cache / "columns").iterdir() if path.suffix != ".lock"]
    assert not intact(Store(source, SMALL))
    assert len(columns(Population.of(source), SMALL)) > 0


def test_a_source_that_fails_leaves_nothing(
    cache: Path, toy: Toy, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = toy()

    def fail(*_: object) -> None:
        raise PopulationError("no such luck")

    monkeypatch.setattr(source, "evaluate", fail)
    with pytest.raises(PopulationError, match="no such luck"):
        columns(Population.of(source), SMALL)
    assert not [path for path in (cache / "columns").iterdir() if path.suffix != ".lock"]


def test_a_full_disk_is_foreseen(cache: Path, toy: Toy, monkeypatch: pytest.MonkeyPatch) -> None:
    import shutil

    usage = shutil.disk_usage("/")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=10))
    with pytest.raises(PopulationError, match="BRDFIT_CACHE"):
        columns(Population.of(toy()), SMALL)


def test_a_disk_that_fills_up_leaves_nothing(
    cache: Path, toy: Toy, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(building, "_put", fail)
    with pytest.raises(PopulationError, match=r"could not be written \(No space left"):
        columns(Population.of(toy()), SMALL)
    assert not [path for path in (cache / "columns").iterdir() if path.suffix != ".lock"]


BUILD = """
import sys, time
from brdfit.grid import Grid
from brdfit.populations import columns, population
from brdfit.populations.published import PublishedFits

evaluate = PublishedFits.evaluate
def slowly(self, wi, wo, pick):
    with open(sys.argv[1], "a") as log:
        log.write("asked\\n")
    time.sleep(0.5)
    return evaluate(self, wi, wo, pick)
PublishedFits.evaluate = slowly
found = columns(population("published"), Grid(6, 6, 8))
print(found.load(0).sum())
"""


def test_two_processes_build_once(cache: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    both = [
        subprocess.Popen([sys.executable, "-c", BUILD, str(log)], stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    sums = [process.communicate(timeout=120)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    assert sums[0] == sums[1] != ""
    # one chunk of rows: whoever came second did not evaluate anything
    assert log.read_text() == "asked\n"
