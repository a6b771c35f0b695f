"""Bad input: each gives a named warning, or an error that says what, where and what to do."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

Run = Callable[..., tuple[int, str, str]]


def _lines(path: Path) -> list[str]:
    return path.read_text().splitlines()


def _glossy(path: Path) -> Path:
    """Write scans of a glossy material, the mirror peak where it belongs."""
    lines = ["theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,value"]
    for theta_i in (20, 40, 60):
        for theta_o in range(5, 81, 5):
            for phi in (0, 90, 180):
                away = np.hypot(theta_o - theta_i, 180 - phi)
                value = 0.05 + 20 * np.exp(-((away / 5) ** 2))
                lines.append(f"{theta_i},0,{theta_o},{phi},{value:.6f}")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_missing_file_is_an_error(run: Run, constant: type, tmp_path: Path) -> None:
    code, _, err = run("fit", tmp_path / "no.astm", "-o", tmp_path / "out.binary")
    assert code == 1
    assert "no.astm: there is no such file" in err
    assert "Traceback" not in err


def test_an_empty_file_is_an_error(run: Run, constant: type, tmp_path: Path) -> None:
    (tmp_path / "empty.csv").touch()
    code, _, err = run("fit", tmp_path / "empty.csv", "-o", tmp_path / "out.binary")
    assert code == 1
    assert "empty" in err
    assert not (tmp_path / "out.binary").exists()


def test_a_truncated_merl_file_is_an_error_with_both_sizes(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "short.binary"
    path.write_bytes(np.array([90, 90, 180], "<i4").tobytes() + bytes(1_000_000))
    code, _, err = run("info", path)
    assert code == 1
    assert "34,992,012" in err
    assert "1,000,012" in err


def test_text_that_is_no_measurement_is_an_error_with_a_way_out(
    run: Run, constant: type, tmp_path: Path
) -> None:
    path = tmp_path / "letter.txt"
    path.write_text("Dear colleague,\nthe measurements follow by post.\n")
    code, _, err = run("fit", path, "-o", tmp_path / "out.binary")
    assert code == 1
    assert "no reader recognises" in err
    assert "letter.txt.toml" in err


def test_columns_that_are_not_clear_are_an_error_with_a_sidecar_to_write(
    run: Run, constant: type, tmp_path: Path
) -> None:
    path = tmp_path / "odd.csv"
    path.write_text("a,b,c,d,e\n10,0,20,180,0.3\n20,0,20,180,0.2\n")
    code, _, err = run("fit", path, "-o", tmp_path / "out.binary")
    assert code == 2
    assert "directions = " in err


def test_declared_columns_are_understood(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "odd.csv"
    path.write_text("a,b,c,d,e\n" + "10,0,20,180,0.3\n20,0,25,180,0.2\n" * 6)
    words = ("--directions", "a,b,c,d", "--values", "e", "--degrees", "--json")
    code, out, _ = run("info", path, *words)
    assert code == 0
    assert json.loads(out)["coverage"]["theta_i"] == pytest.approx([10.0, 20.0])


def test_degrees_declared_as_radians_are_warned_of(run: Run, tmp_path: Path) -> None:
    path = _glossy(tmp_path / "glossy.csv")
    names = "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg"
    code, _, err = run("info", path, "--radians", "--directions", names, "--values", "value")
    assert code in (0, 1)
    assert "Warning" in err
    assert "degrees" in err


def test_an_azimuth_counted_from_the_other_side_is_warned_of(run: Run, tmp_path: Path) -> None:
    path = _glossy(tmp_path / "glossy.csv")
    turned = {"0": "180", "180": "0"}
    lines = [line.split(",") for line in _lines(path)]
    lines = [[*row[:3], turned.get(row[3], row[3]), row[4]] for row in lines]
    path.write_text("\n".join(map(",".join, lines)) + "\n")
    code, _, err = run("info", path)
    assert code == 0
    assert "ConventionWarning" in err
    assert "azimuth" in err


def test_light_and_detector_exchanged_are_warned_of(run: Run, tmp_path: Path) -> None:
    lines = ["theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,value"]
    for theta_i in range(10, 81, 10):
        for theta_o in range(10, 81, 10):
            for phi in (0, 60, 120, 180):
                # what the detector sees of a reciprocal BRDF: f_r times its cosine
                value = (0.1 + 0.001 * (theta_i + theta_o)) * np.cos(np.radians(theta_o))
                lines.append(f"{theta_i},0,{theta_o},{phi},{value:.8f}")
    path = tmp_path / "weighted.csv"
    path.write_text("\n".join(lines) + "\n")
    assert "Warning" not in run("info", path, "--cosine-weighted")[2]
    code, _, err = run("info", path, "--cosine-weighted", "--light", "second")
    assert code == 0
    assert "ConventionWarning" in err
    assert "exchanged" in err


def test_nan_and_negative_values_are_flagged_and_counted(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    lines = _lines(paint_csv)
    lines[3] = lines[3].rsplit(",", 3)[0] + ",nan,nan,nan"
    lines[5] = lines[5].rsplit(",", 3)[0] + ",-0.1,0.1,0.1"
    lines[8] = "x,y,z,?,1,1,1"
    paint_csv.write_text("\n".join(lines) + "\n")
    code, out, err = run("fit", paint_csv, "-o", tmp_path / "out.binary")
    assert code == 0, err
    assert "60 samples, 3 channels (R, G, B), 58 usable" in out
    assert "1 censored" in out
    assert "row 6" in out
    assert "DataQualityWarning" in err
    assert "rows 4, 9" in err
    record = json.loads((tmp_path / "out.json").read_text())
    assert record["samples"]["count"] == 60
    assert record["samples"]["flags"]["censored"] == 1
    assert any("DataQualityWarning" in line for line in record["warnings"])


def test_three_samples_are_warned_of(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    paint_csv.write_text("\n".join(_lines(paint_csv)[:4]) + "\n")
    code, _, err = run("fit", paint_csv, "-o", tmp_path / "out.binary")
    assert code == 0, err
    assert "DataQualityWarning" in err
    assert "only 3 usable samples" in err


def test_duplicate_directions_are_flagged(run: Run, paint_csv: Path) -> None:
    lines = _lines(paint_csv)
    paint_csv.write_text("\n".join([*lines, *lines[1:6]]) + "\n")
    code, out, _ = run("info", paint_csv)
    assert code == 0
    assert "5 duplicate" in out
    assert "rows 62, 63" in out


def test_directions_below_the_horizon_are_flagged_and_not_used(run: Run, paint_csv: Path) -> None:
    text = paint_csv.read_text().replace("60,0,65,", "60,0,95,")
    paint_csv.write_text(text)
    code, out, err = run("info", paint_csv)
    assert code == 0
    assert "4 below_horizon" in out
    assert "56 usable" in out
    assert "DataQualityWarning" in err


def test_a_file_without_one_usable_row_is_an_error(
    run: Run, constant: type, paint_csv: Path, tmp_path: Path
) -> None:
    lines = [line.rsplit(",", 3)[0] + ",nan,nan,nan" for line in _lines(paint_csv)[1:]]
    paint_csv.write_text("\n".join([_lines(paint_csv)[0], *lines]) + "\n")
    code, _, err = run("fit", paint_csv, "-o", tmp_path / "out.binary")
    assert code == 1
    assert "found 0 usable samples of 60" in err
    assert not (tmp_path / "out.binary").exists()


def test_a_folder_as_input_is_an_error(run: Run, constant: type, tmp_path: Path) -> None:
    code, _, err = run("fit", tmp_path, "-o", tmp_path / "out.binary")
    assert code == 1
    assert "folder" in err


def test_samples_where_a_table_is_wanted_are_to_be_fitted_first(run: Run, tmp_path: Path) -> None:
    samples = _glossy(tmp_path / "glossy.csv")
    code, _, err = run("render", samples, "-o", tmp_path / "picture.png")
    assert code == 2
    assert "Fit it first, with `brdfit fit`" in err
