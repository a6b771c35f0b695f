"""What is written is read back, at the precision that the format's data sheet states.

The fixtures have no symmetry: light and detector, left and right of the plane of incidence,
and all channels differ. The test runs over the registry, so a new writer is under it as soon
as its format is listed.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import brdfit
from brdfit.errors import BrdfitWarning
from brdfit.formats.sheet import HEAD_BYTES, FormatSheet
from brdfit.geometry import half_diff_from_directions
from brdfit.samples import Samples
from brdfit.table import Table
from brdfit.tone import LUMINANCE

from small_files import tiny_samples, tiny_table, written_table

SHEETS = {sheet.name: sheet for sheet in brdfit.list_formats()}
WRITE_SAMPLES = [name for name, sheet in SHEETS.items() if sheet.write_samples is not None]
WRITE_TABLE = [name for name, sheet in SHEETS.items() if sheet.write_table is not None]

# Directions are stored with the digits of the values.
_DIRECTION = 1e-7
MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(autouse=True)
def _only_foreign_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BrdfitWarning)
        yield


def path_for(sheet: FormatSheet, folder: Path) -> Path:
    return folder / f"there{sheet.extensions[0]}"


def claims(path: Path) -> str:
    """Return the format whose turn it is with the content of a file."""
    head = path.read_bytes()[:HEAD_BYTES]
    return next(sheet.name for sheet in brdfit.list_formats() if sheet.sniff(path, head))


def assert_close(got: np.ndarray, expected: np.ndarray, precision: float) -> None:
    if precision == 0.0:
        np.testing.assert_array_equal(got, expected)
    else:
        np.testing.assert_allclose(got, expected, rtol=precision, atol=1e-12)


def test_the_fixtures_would_show_an_exchange() -> None:
    samples = tiny_samples()
    value = samples.value
    assert not np.isclose(samples.wi, samples.wo).all(axis=1).any()
    assert (np.abs(np.diff(value, axis=1)) > 0.1).all()
    table = tiny_table()
    theta_h, theta_d, phi_d = half_diff_from_directions(samples.wi, samples.wo)
    there = table.interpolate(*table.grid.corners(theta_h, theta_d, phi_d))
    mirrored = table.interpolate(*table.grid.corners(theta_h, theta_d, np.pi - phi_d))
    assert (np.abs(there / mirrored - 1.0).max(axis=0) > 0.1).all()
    assert (np.abs(there[:, 1:] / there[:, :-1] - 1.0) > 0.1).all()


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("name", WRITE_SAMPLES)
def test_samples_come_back(name: str, channels: int, tmp_path: Path) -> None:
    sheet, samples = SHEETS[name], tiny_samples(channels=channels)
    path = path_for(sheet, tmp_path)
    brdfit.write_samples(samples, path, format=name)
    back = brdfit.read_samples(path)
    assert claims(path) == name
    assert back.channels == samples.channels
    assert_close(back.value, samples.value, sheet.precision)
    for got, expected in ((back.wi, samples.wi), (back.wo, samples.wo)):
        np.testing.assert_allclose(got, expected, atol=min(sheet.precision, _DIRECTION))


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("name", WRITE_TABLE)
def test_tables_come_back(name: str, channels: int, tmp_path: Path) -> None:
    sheet = SHEETS[name]
    path = path_for(sheet, tmp_path)
    table = written_table(name, path, channels)
    assert claims(path) == name
    if sheet.read_table is not None:
        assert_same_function(brdfit.read_table(path), table, sheet)
    if sheet.read_samples is not None and sheet.write_samples is None:
        assert_samples_of(brdfit.read_samples(path), table, sheet)


def assert_same_function(back: Table, table: Table, sheet: FormatSheet) -> None:
    """The same cells where the grid is kept, else the same values at any directions."""
    if back.grid == table.grid:
        shared = back.mask & table.mask
        assert shared.sum() == table.mask.sum()
        assert_close(back.values[shared], spread(table.values[shared], back), sheet.precision)
        return
    wi, wo = upper_pairs()
    assert_values(back.evaluate(wi, wo), wi, wo, back, table, sheet)


def assert_samples_of(back: Samples, table: Table, sheet: FormatSheet) -> None:
    """A table read back as samples: each is the table's value at its directions."""
    usable = back.usable.all(axis=1)
    assert usable.sum() >= 20
    wi, wo = back.wi[usable], back.wo[usable]
    assert_values(back.value[usable], wi, wo, back, table, sheet)


def assert_values(
    got: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    back: Samples | Table,
    table: Table,
    sheet: FormatSheet,
) -> None:
    """What came back is the table's value at the same directions."""
    expected = spread(table.evaluate(wi, wo), back)
    if not sheet.averages:
        assert_close(got, expected, sheet.precision)
        return
    mirrored = spread(table.evaluate(wi * MIRROR, wo * MIRROR), back)
    off = np.abs(got / expected - 1.0)
    assert (np.median(off, axis=0) < sheet.precision).all()
    assert (np.percentile(off, 95, axis=0) < 5.0 * sheet.precision).all()
    # the mirror image of the material would be noticed
    assert (np.abs(got / mirrored - 1.0).mean(axis=0) > 5.0 * off.mean(axis=0)).all()


def spread(values: np.ndarray, back: Samples | Table) -> np.ndarray:
    """One channel that came back as three is the same in all; three as one are luminance."""
    if values.shape[-1] == 3 and back.n_channels == 1:
        return (values @ np.array(LUMINANCE))[..., None]
    return np.broadcast_to(values, (*values.shape[:-1], back.n_channels))


def upper_pairs() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    cos_theta, phi = rng.uniform(0.3, 0.98, (2, 300)), rng.uniform(-np.pi, np.pi, (2, 300))
    wi, wo = brdfit.directions_from_spherical(np.arccos(cos_theta), phi)
    return wi, wo


@pytest.mark.parametrize("name", WRITE_TABLE)
def test_writing_the_same_table_twice_gives_the_same_bytes(name: str, tmp_path: Path) -> None:
    first, second = tmp_path / "a", tmp_path / "b"
    first.mkdir(), second.mkdir()
    one, two = path_for(SHEETS[name], first), path_for(SHEETS[name], second)
    written_table(name, one)
    written_table(name, two)
    assert one.read_bytes() == two.read_bytes()
