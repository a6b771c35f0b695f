"""`brdfit info` tells of a fit from the record that it left."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def fitted(run: Run, constant: type, paint_csv: Path, tmp_path: Path) -> tuple[Path, str]:
    """Return the record of a fit, and what the fit said."""
    code, out, err = run("fit", paint_csv, "-o", tmp_path / "out.npz", "--error-metric", "linear")
    assert code == 0, err
    return tmp_path / "out.json", out


def test_the_record_says_what_the_fit_said(run: Run, fitted: tuple[Path, str]) -> None:
    record, said = fitted
    code, out, err = run("info", record)
    assert code == 0, err
    assert out.startswith("out.json: record of a fit of paint.csv, 60 samples, 3 channels\n")
    told = [
        line
        for line in said.splitlines()
        if line.split()[:1]
        in (["fit"], ["ended"], ["outliers"], ["rule"], ["residuals"], ["albedo"])
    ]
    assert len(told) == 6
    for line in told:
        assert line in out
    assert "out.npz" in out


def test_the_record_as_json_is_itself(run: Run, fitted: tuple[Path, str]) -> None:
    record, _ = fitted
    assert json.loads(run("info", record, "--json")[1]) == json.loads(record.read_text())


@pytest.mark.parametrize(
    "words",
    [
        ("info", "--physics"),
        ("render", "-o", "sphere.png"),
        ("convert", "other.npz"),
        ("export", "-o", "material.mtlx"),
    ],
)
def test_what_wants_a_table_names_that_of_the_fit(
    run: Run, fitted: tuple[Path, str], words: tuple[str, ...]
) -> None:
    command, *rest = words
    code, _, err = run(command, fitted[0], *rest)
    assert code == 2
    assert "is the record of a fit; name out.npz instead" in err


def test_a_record_that_lost_a_part_is_said_to_be_one(run: Run, tmp_path: Path) -> None:
    damaged = tmp_path / "half.json"
    damaged.write_text('{"schema": "brdfit.fit/1", "outcome": {}}')
    code, _, err = run("info", damaged)
    assert code == 1
    assert "record of a fit but has no entry 'samples'" in err


@pytest.mark.parametrize("outputs", [None, [], "out.npz"])
def test_a_record_that_names_no_files_is_told_of_without(
    run: Run, fitted: tuple[Path, str], outputs: object
) -> None:
    record, _ = fitted
    record.write_text(json.dumps(json.loads(record.read_text()) | {"outputs": outputs}))
    code, out, err = run("info", record)
    assert code == 0, err
    assert "files" not in out
    assert run("info", record, "--physics")[0] == 2


def test_json_of_another_kind_is_not_taken_for_a_record(run: Run, tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text('{"schema": "something/1"}')
    code, _, err = run("info", other)
    assert code != 0
    assert "no reader recognises" in err
