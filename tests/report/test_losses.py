"""What a conversion says of itself: every aspect measured on the file that was written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.errors import UsageError
from brdfit.formats import format_to_write, write_samples, write_table
from brdfit.grid import MERL_GRID, Grid
from brdfit.report.conversion import Converted, convert
from brdfit.report.losses import Loss, losses_of
from brdfit.samples import Flag, Samples, Source
from brdfit.table import Table

from small_files import tiny_samples, tiny_table

pytestmark = pytest.mark.filterwarnings("ignore::brdfit.errors.BrdfitWarning")

COARSE = Grid(6, 5, 8)


def done(content: Samples | Table, target: Path, to: str | None = None) -> Converted:
    return convert(content, target.with_suffix(".in"), target, format_to_write(target, format=to))


def of(converted: Converted, aspect: str) -> Loss:
    (loss,) = (loss for loss in converted.losses if loss.aspect == aspect)
    return loss


def table_of(channels: int = 3, **more: Any) -> Table:
    values = np.random.default_rng(2).uniform(0.1, 2.0, (*COARSE.shape, channels))
    return Table(values, grid=COARSE, **more)


def test_the_projects_own_format_loses_nothing(tmp_path: Path) -> None:
    source = Source(
        name="a.csv", format="delimited", sha256="f0", notes=("n",), metadata={"k": "v"}
    )
    assert done(table_of(5, source=source), tmp_path / "a.npz").lost == ()
    marked = tiny_samples().with_flags(np.arange(12) < 2, Flag.REJECTED)
    for name in ("a.npz", "a.csv", "a.parquet"):
        assert done(marked, tmp_path / name).lost == (), name


def test_values_below_zero_and_rounding_are_counted(tmp_path: Path) -> None:
    values = np.full((*MERL_GRID.shape, 3), 0.25, dtype=np.float32)
    i, j, k = np.unravel_index(MERL_GRID.cells[:7], MERL_GRID.shape)
    values[i, j, k] = -1.0
    converted = done(Table(values), tmp_path / "a.binary")
    assert of(converted, "range").figures == {"clipped": 21}
    assert not of(converted, "precision").lost
    assert "21 values below zero became 0" in of(converted, "range").sentence


def test_half_a_float_is_said_in_figures(tmp_path: Path) -> None:
    converted = done(table_of(), tmp_path / "a.exr")
    precision = of(converted, "precision")
    assert precision.lost
    assert 1e-9 < precision.figures["largest"] < 6e-8
    assert not of(converted, "resolution").lost


def test_cells_and_values_of_the_format_are_counted(tmp_path: Path) -> None:
    table = tiny_table(Grid(30, 30, 30))
    converted = done(table, tmp_path / "a.bsdf", "zemax")
    resolution = of(converted, "resolution")
    assert resolution.lost
    assert resolution.figures["cells"] == table.mask.sum()
    assert (
        resolution.figures["values"] == brdfit.read_samples(tmp_path / "a.bsdf").usable[:, 0].sum()
    )


def test_a_lobe_that_the_format_spreads_is_told_by_its_largest_value(tmp_path: Path) -> None:
    grid = Grid(40, 20, 20)
    lobe = 0.1 + 500.0 * np.exp(-((grid.theta_h / 0.02) ** 2))
    table = Table(np.broadcast_to(lobe[:, None, None, None], (*grid.shape, 1)), grid=grid)
    spread = of(done(table, tmp_path / "a.xml", "klems"), "range")
    assert spread.lost
    assert spread.figures["largest_before"] == pytest.approx(500.1)
    assert spread.figures["largest_after"] < 250.0


def test_a_table_on_the_grid_of_the_format_is_measured_between(tmp_path: Path) -> None:
    converted = done(tiny_table(), tmp_path / "a.bsdf")
    figures = of(converted, "resolution").figures
    assert 0.0 < figures["median"] < 0.01
    assert figures["values"] > figures["cells"]


def test_colour_that_becomes_luminance_is_lost(tmp_path: Path) -> None:
    converted = done(tiny_table(), tmp_path / "a.xml")
    assert of(converted, "channels").lost
    # what remains is compared with the luminance, not with red
    assert of(converted, "precision").figures["largest"] < 1e-5


def test_one_channel_written_three_times_is_no_loss(tmp_path: Path) -> None:
    channels = of(done(tiny_table(MERL_GRID, 1), tmp_path / "a.binary"), "colour")
    assert not channels.lost
    assert "written three times" in channels.sentence


def test_a_spectrum_becomes_a_colour_where_the_format_holds_no_more(tmp_path: Path) -> None:
    waves = np.linspace(430.0, 640.0, 4)
    for to in ("zemax", "lighttools", "rgl"):
        smooth = Table(tiny_table(channels=4).values, grid=COARSE, wavelengths=waves)
        converted = done(smooth, tmp_path / "a.bsdf", to)
        lost = {"colour", "channels"} & set(converted.lost)
        assert lost == (set() if to == "rgl" else {"colour", "channels"}), to


def test_wavelengths_out_of_order_are_followed(tmp_path: Path) -> None:
    table = tiny_table(channels=3)
    upside_down = Table(table.values, grid=table.grid, wavelengths=np.array([650.0, 550.0, 450.0]))
    converted = done(upside_down, tmp_path / "a.bsdf")
    assert of(converted, "resolution").figures["median"] < 0.01
    assert of(converted, "channels").sentence == "the wavelengths were put in order"


def test_another_grid_is_interpolated_for_the_format_that_has_one(tmp_path: Path) -> None:
    table = tiny_table()
    converted = done(table, tmp_path / "a.binary")
    assert of(converted, "grid").figures["after"] == [90, 90, 180]
    back = brdfit.read_table(tmp_path / "a.binary")
    wi, wo = back.grid.directions(back.grid.cells[::5000])
    expected = table.evaluate(wi, wo)
    np.testing.assert_allclose(back.evaluate(wi, wo), expected, rtol=1e-10)


def test_cells_without_a_measurement_that_a_format_fills_are_said(tmp_path: Path) -> None:
    valid = np.ones(COARSE.shape, dtype=bool)
    valid[2] = False
    table = Table(tiny_table(channels=1).values, grid=COARSE, valid=valid)
    assert of(done(table, tmp_path / "a.bsdf", "zemax"), "missing").lost
    assert of(done(table, tmp_path / "b.bsdf", "rgl"), "missing").lost
    kept = of(done(table, tmp_path / "a.npz"), "missing")
    assert not kept.lost
    assert kept.figures["before"] == table.missing > 0


def test_what_samples_lose_in_a_format_of_numbers_only(tmp_path: Path) -> None:
    plain = tiny_samples(channels=1)
    samples = Samples(
        wi=plain.wi,
        wo=plain.wo,
        value=plain.value,
        sigma=np.full((12, 1), 0.01),
        wavelengths=np.array([632.8]),
        rows=np.arange(12) + 100,
        flags=np.where(np.arange(12) < 2, int(Flag.REJECTED), 0),
        source=Source(name="x.csv", format="delimited", sha256="f00", metadata={"k": "v"}),
    )
    alta = done(samples, tmp_path / "a.alta")
    assert set(alta.lost) == {"channels", "flags", "deviations", "rows", "metadata"}
    assert of(alta, "flags").figures == {"before": 2, "after": 0}
    assert of(alta, "metadata").sentence == "1 header field"
    assert not of(alta, "directions").lost
    astm = done(samples, tmp_path / "a.astm")
    assert set(astm.lost) == {"flags", "rows", "metadata"}


def test_a_turn_of_the_sample_that_is_lost_is_called_anisotropy(tmp_path: Path) -> None:
    samples = tiny_samples()
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    turned = Samples(wi=samples.wi @ turn, wo=samples.wo @ turn, value=samples.value)
    moved = Samples(wi=samples.wo, wo=samples.wi[::-1], value=samples.value)
    sheet = format_to_write("a.csv")
    for other, aspect in ((turned, "anisotropy"), (moved, "directions")):
        write_samples(other, tmp_path / "a.csv")
        losses = losses_of(samples, samples, tmp_path / "a.csv", sheet)
        assert [loss.lost for loss in losses if loss.aspect == aspect] == [True]


def test_samples_that_are_gone_are_counted(tmp_path: Path) -> None:
    samples = tiny_samples()
    write_samples(samples.subset(np.arange(5)), tmp_path / "a.csv")
    losses = losses_of(samples, samples, tmp_path / "a.csv", format_to_write("a.csv"))
    assert ("samples", True) in [(loss.aspect, loss.lost) for loss in losses]


def test_a_table_interpolated_from_a_files_own_values_says_so(tmp_path: Path) -> None:
    origin = tmp_path / "a.bsdf"
    write_table(tiny_table(), origin)
    table = brdfit.read_table(origin)
    converted = convert(table, origin, tmp_path / "a.npz", format_to_write("a.npz"))
    assert of(converted, "reading").figures["values"] == len(brdfit.read_samples(origin))
    # the same table from a file of ours: nothing is interpolated any more
    again = brdfit.read_table(tmp_path / "a.npz")
    second = convert(again, tmp_path / "a.npz", tmp_path / "b.npz", format_to_write("b.npz"))
    assert second.lost == ()


def test_what_the_format_cannot_hold_is_refused_with_the_way_out(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="brdfit fit"):
        done(tiny_samples(), tmp_path / "a.binary")
    with pytest.raises(UsageError, match="brdfit evaluate"):
        done(tiny_table(), tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())
