"""The commands on good input, end to end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import brdfit.report.fit_outputs as fit_outputs
from brdfit.errors import DataQualityWarning
from brdfit.formats import read_samples, read_table, write_samples, write_table
from brdfit.grid import MERL_GRID, Grid
from brdfit.table import Table

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def grey_table(tmp_path: Path) -> Path:
    """Return a .binary of albedo 0.5 in all cells."""
    path = tmp_path / "grey.binary"
    write_table(Table(values=np.full((*MERL_GRID.shape, 3), 0.5 / np.pi)), path)
    return path


def test_fit_says_what_it_read_and_did_and_wrote(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    code, out, err = run(
        "fit", paint_csv, "-o", tmp_path / "out.binary", "--error-metric", "linear"
    )
    assert code == 0, err
    for expected in (
        "paint.csv: 60 samples, 3 channels (R, G, B), 60 usable",
        "coverage    theta_i 10-60",
        "flagged",
        "ended       direct",
        "outliers    ",
        "residuals   median |ln(value / result)|",
        "out.binary",
        "out.png",
        "out.json",
        "out.csv",
    ):
        assert expected in out
    record = json.loads((tmp_path / "out.json").read_text())
    assert record["method"]["error_metric"] == "linear"
    assert record["command"] == "fit"
    assert record["samples"]["source"]["sha256"]
    assert read_table(tmp_path / "out.binary").mask.sum() == MERL_GRID.cells.size


def test_fit_tells_the_albedo_and_the_limit_is_an_option(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    samples = read_samples(paint_csv)
    white = samples.value * 1.1 / (np.pi * samples.value.mean())
    write_samples(samples.with_value(white), tmp_path / "white.csv")
    words = ("fit", tmp_path / "white.csv", "-o", tmp_path / "out.npz")
    code, out, _ = run(*words)
    assert code == 0
    assert "more light leaves than arrives" in out
    assert "--limit-albedo lowers it where nobody measured" in out
    code, out, err = run(*words, "--limit-albedo")
    assert code == 0
    assert "cells that nobody measured were lowered" in out + err
    told = json.loads((tmp_path / "out.json").read_text())["albedo"]["limited"]
    assert told["largest_after"] < told["largest_before"]
    assert told["cells_lowered"]["measured"] == 0


def test_info_tells_the_albedo_of_a_table(run: Run, grey_table: Path) -> None:
    _, out, _ = run("info", grey_table)
    assert "albedo      at most 0.500" in out
    _, out, _ = run("info", grey_table, "--json")
    assert json.loads(out)["albedo"]["largest"] == pytest.approx(0.5, rel=1e-3)


def test_quiet_prints_nothing_of_a_good_fit(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    code, out, err = run("fit", paint_csv, "-o", tmp_path / "out.npz", "--quiet")
    assert (code, out, err) == (0, "", "")


def test_the_csv_beside_the_table_does_not_replace_an_input_of_that_name(
    run: Run, constant: type, paint_csv: Path
) -> None:
    before = paint_csv.read_bytes()
    code, out, _ = run("fit", paint_csv, "-o", paint_csv.with_suffix(".binary"))
    assert code == 0
    assert paint_csv.read_bytes() == before
    assert "paint.fit.csv" in out
    assert (paint_csv.parent / "paint.fit.csv").is_file()


def test_relative_paths_work_from_any_folder(
    run: Run, constant: type, paint_csv: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (paint_csv.parent / "elsewhere").mkdir()
    monkeypatch.chdir(paint_csv.parent / "elsewhere")
    code, _, err = run("fit", "../paint.csv", "-o", "out.npz")
    assert code == 0, err
    assert sorted(os.listdir()) == ["out.csv", "out.json", "out.npz", "out.png"]


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ("missing/out.binary", "does not exist"),
        ("out.tiff", "'.tiff' does not say how to write a table"),
        ("paint.csv", "does not say how to write a table"),
    ],
)
def test_a_bad_output_is_refused_before_the_input_is_read(
    run: Run, constant: type, tmp_path: Path, output: str, said: str
) -> None:
    code, _, err = run("fit", tmp_path / "not-there.csv", "-o", tmp_path / output)
    assert code == 2
    assert said in err
    assert "not-there" not in err


def test_ctrl_c_exits_with_130_and_leaves_nothing(
    run: Run,
    constant: type,
    paint_csv: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fit_outputs, "draw_fit", interrupted)
    code, _, err = run("fit", paint_csv, "-o", tmp_path / "out.binary")
    assert code == 130
    assert "stopped" in err
    assert os.listdir(tmp_path) == ["paint.csv"]


def test_a_defect_is_one_line_and_debug_shows_where(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*arguments: object) -> None:
        raise RuntimeError("cogwheel")

    monkeypatch.setattr(constant, "fit", broken)
    words = ("fit", paint_csv, "-o", tmp_path / "out.binary")
    code, _, err = run(*words)
    assert code == 1
    assert "RuntimeError: cogwheel" in err
    assert "Traceback" not in err
    code, _, err = run(*words, "--debug")
    assert code == 1
    assert "Traceback" in err


def test_info_of_samples_as_json(run: Run, paint_csv: Path) -> None:
    code, out, _ = run("info", paint_csv, "--json")
    record = json.loads(out)
    assert code == 0
    assert record["kind"] == "samples"
    assert record["count"] == record["usable"] == 60
    assert record["coverage"]["theta_i"] == pytest.approx([10.0, 60.0])


def test_info_of_a_table(run: Run, grey_table: Path) -> None:
    code, out, _ = run("info", grey_table)
    assert code == 0
    assert "90 x 90 x 180" in out
    assert f"{MERL_GRID.cells.size:,} valid, 0 missing" in out
    record = json.loads(run("info", grey_table, "--json")[1])
    assert record["ranges"]["G"]["median"] == pytest.approx(0.5 / np.pi)


def test_convert_between_files_of_samples(run: Run, paint_csv: Path, tmp_path: Path) -> None:
    code, out, _ = run("convert", paint_csv, tmp_path / "paint.parquet")
    assert code == 0
    assert "samples" in out
    before, after = read_samples(paint_csv), read_samples(tmp_path / "paint.parquet")
    assert after.value == pytest.approx(before.value)
    assert after.wi == pytest.approx(before.wi)


def test_convert_between_tables(run: Run, grey_table: Path, tmp_path: Path) -> None:
    code, _, _ = run("convert", grey_table, tmp_path / "grey.npz")
    assert code == 0
    assert np.array_equal(read_table(tmp_path / "grey.npz").values, read_table(grey_table).values)


def test_convert_does_not_make_a_table_of_samples(run: Run, paint_csv: Path) -> None:
    code, _, err = run("convert", paint_csv, paint_csv.with_suffix(".binary"))
    assert code == 2
    assert "brdfit fit" in err
    assert not paint_csv.with_suffix(".binary").exists()


def test_evaluate_at_directions_without_values(run: Run, grey_table: Path, tmp_path: Path) -> None:
    at = tmp_path / "at.csv"
    at.write_text("theta_h,theta_d,phi_d\n5,20,90\n1,60,90\n80,80,0\n")
    code, _, err = run("evaluate", grey_table, "--at", at, "--degrees", "-o", tmp_path / "out.csv")
    assert code == 0, err
    assert "1 of 3 directions" in err
    with pytest.warns(DataQualityWarning):
        found = read_samples(tmp_path / "out.csv")
    assert found.value[:2] == pytest.approx(0.5 / np.pi)
    assert np.isnan(found.value[2]).all()


def test_evaluate_at_the_directions_of_measurements(
    run: Run, grey_table: Path, paint_csv: Path, tmp_path: Path
) -> None:
    code, _, err = run("evaluate", grey_table, "--at", paint_csv, "-o", tmp_path / "out.csv")
    assert code == 0, err
    found = read_samples(tmp_path / "out.csv")
    assert len(found) == 60
    assert found.wi == pytest.approx(read_samples(paint_csv).wi)


def test_render_writes_a_picture_of_the_asked_size(
    run: Run, grey_table: Path, tmp_path: Path
) -> None:
    from matplotlib.image import imread

    picture = tmp_path / "sphere.png"
    code, _, err = run("render", grey_table, "-o", picture, "--size", "24")
    assert code == 0, err
    pixels = imread(picture)
    assert pixels.shape[:2] == (24, 24)
    assert pixels[12, 12, :3].min() > 0.1
    assert pixels[0, 0, :3].max() == 0.0


def test_compare_a_table_with_itself_is_zero(run: Run, grey_table: Path) -> None:
    code, out, _ = run("compare", grey_table, grey_table, "--json", "--size", "16")
    record = json.loads(out)
    assert code == 0
    assert record["images"]["studio"]["perceptual_error"] == 0.0
    assert record["values"]["log_rms"]["value"] == 0.0


def test_basis_list_names_what_is_ready(run: Run) -> None:
    code, out, _ = run("basis", "list")
    assert code == 0
    assert "published" in out
    assert "terms:" in out
    assert {one["name"] for one in json.loads(run("basis", "list", "--json")[1])} >= {"published"}


def test_basis_check_of_the_embedded_population_is_good(run: Run) -> None:
    code, out, _ = run("basis", "check", "published")
    assert code == 0
    assert "members: ok. 200" in out


def test_a_reader_that_goes_away_does_not_stop_the_work(paint_csv: Path) -> None:
    command = [sys.executable, "-m", "brdfit", "info", str(paint_csv)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 0


_SLOW_PICTURE = """
import sys, time
import brdfit.report.fit_outputs as fit_outputs
from brdfit.cli import main
def draw(result, brdf, rgb, coverage, path, progress):
    path.write_text("half")
    print("drawing", flush=True)
    time.sleep(60)
fit_outputs.draw_fit = draw
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_a_fit_that_is_stopped_while_it_writes_leaves_nothing(
    paint_csv: Path, number: signal.Signals, code: int
) -> None:
    words = ["fit", str(paint_csv), "-o", str(paint_csv.with_suffix(".npz"))]
    command = [sys.executable, "-c", _SLOW_PICTURE, *words, "-q", "--method", "tabulated"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "drawing\n"
        process.send_signal(number)
        assert process.wait(30) == code
    assert os.listdir(paint_csv.parent) == ["paint.csv"]


def test_render_under_a_panorama_and_on_a_sheet(run: Run, tmp_path: Path) -> None:
    from matplotlib.image import imread

    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"
    (tmp_path / "sky.hdr").write_bytes(header + bytes([90, 90, 90, 128]) * 8)
    for name in ("a", "b"):
        values = np.full((6, 6, 4, 3), 0.2 if name == "a" else 0.1)
        write_table(Table(values=values, grid=Grid(6, 6, 4)), tmp_path / f"{name}.npz")
    both = [tmp_path / "a.npz", tmp_path / "b.npz"]
    sheet = tmp_path / "sheet.png"
    words = ("--environment", tmp_path / "sky.hdr", "--samples", "8", "--size", "20")
    code, out, err = run("render", *both, "--sheet", "-o", sheet, *words)
    assert code == 0, err
    assert "2 spheres under sky.hdr" in out
    assert imread(sheet).shape[:2] == (58, 64)
    code, _, err = run("render", *both, "-o", sheet)
    assert code == 2
    assert "--sheet" in err
    code, _, err = run("render", both[0])
    assert code == 2
    assert "-o" in err


def test_convert_says_what_is_lost(run: Run, grey_table: Path, tmp_path: Path) -> None:
    code, out, err = run("convert", grey_table, tmp_path / "grey.bsdf", "--to", "zemax")
    assert code == 0
    assert "(table, zemax)" in out
    assert "  resolution  LOST 1,111,430 cells" in err
    assert "  channels    kept: 3 channels (R, G, B)" in err
    quiet = run("-q", "convert", grey_table, tmp_path / "grey.bsdf", "--to", "zemax")
    assert (quiet.out, quiet.err) == ("", "")


def test_convert_for_scripts(run: Run, grey_table: Path, tmp_path: Path) -> None:
    code, out, _ = run("convert", grey_table, tmp_path / "grey.exr", "--json")
    assert code == 0
    record = json.loads(out)
    assert record["format"] == "exr"
    assert set(record["lost"]) == {"precision", "metadata"} & set(record["lost"])
    aspects = {loss["aspect"]: loss for loss in record["losses"]}
    assert aspects["precision"]["figures"]["largest"] < 6e-8
    assert record["input"]["sha256"] != record["output"]["sha256"]


def test_a_suffix_of_several_formats_names_the_others(
    run: Run, grey_table: Path, tmp_path: Path
) -> None:
    _, out, _ = run("convert", grey_table, tmp_path / "grey.xml")
    assert "(table, tensortree; --to klems writes another .xml)" in out


def test_a_format_that_does_not_exist_names_those_that_do(
    run: Run, grey_table: Path, tmp_path: Path
) -> None:
    code, _, err = run("convert", grey_table, tmp_path / "grey.bsdf", "--to", "zemx")
    assert code == 2
    assert "Did you mean 'zemax'" in err
    assert "lighttools" in err
    code, _, err = run("convert", grey_table, tmp_path / "grey.bsdf", "--format", "zemax")
    assert code == 2
    assert "for the output: --to zemax" in err
    assert list(tmp_path.iterdir()) == [grey_table]


def test_a_folder_in_place_of_an_output_is_called_one(
    run: Run, grey_table: Path, tmp_path: Path
) -> None:
    for words in (("convert", grey_table, tmp_path), ("repair", grey_table, "-o", tmp_path)):
        code, _, err = run(*words)
        assert code == 2
        assert "is a folder" in err


def test_fit_and_repair_take_the_format_of_their_output(
    run: Run, constant: type, paint_csv: Path, grey_table: Path, tmp_path: Path
) -> None:
    assert run("fit", paint_csv, "-o", tmp_path / "a.bsdf", "--to", "lighttools").code == 0
    assert read_samples(tmp_path / "a.bsdf").source.format == "lighttools"
    assert run("repair", grey_table, "-o", tmp_path / "b.xml", "--to", "klems").code == 0
    assert read_samples(tmp_path / "b.xml").source.format == "klems"
    code, _, err = run("fit", tmp_path / "none.csv", "-o", tmp_path / "c.bsdf", "--to", "nist")
    assert code == 2
    assert "cannot be written as a table" in err
