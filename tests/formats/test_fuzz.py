"""A share of what `tools/fuzz_readers.py` does: damage gives a result or an error of ours."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.formats.sheet import FormatSheet

from mutations import mutated
from small_files import ENVIRONMENT, small_files
from source_tree import ROOT

TOOL = ROOT / "tools" / "fuzz_readers.py"
SHEETS = {sheet.name: sheet for sheet in brdfit.list_formats()}

INPUTS = 2500


def run(*options: str) -> tuple[int, dict[str, Any]]:
    """Run the tool; (exit status, record)."""
    path = os.pathsep.join([str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, str(TOOL), *options],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)


def test_mutated_files_give_a_result_or_say_why_not() -> None:
    status, record = run("--inputs", str(INPUTS), "--seed", "7")
    assert record["findings"] == []
    assert status == 0
    assert sum(sum(outcomes.values()) for outcomes in record["outcomes"].values()) == INPUTS
    readable = {n for n, s in SHEETS.items() if s.read_samples or s.read_table}
    assert set(record["outcomes"]) == readable | {ENVIRONMENT}


def test_a_file_cut_at_any_byte_gives_a_result_or_says_why_not() -> None:
    status, record = run("--truncations")
    assert record["findings"] == []
    assert status == 0
    assert record["inputs"] > 5000


@pytest.fixture(scope="module")
def kinds(tmp_path_factory: pytest.TempPathFactory) -> set[tuple[str, str]]:
    folder = tmp_path_factory.mktemp("small")
    return {(small.format, small.kind) for small in small_files(folder)}


@pytest.mark.parametrize("sheet", SHEETS.values(), ids=SHEETS)
def test_every_reader_has_a_small_file(sheet: FormatSheet, kinds: set[tuple[str, str]]) -> None:
    assert any(format == sheet.name for format, _ in kinds), "add one to tools/small_files.py"


@pytest.mark.filterwarnings("ignore::brdfit.errors.BrdfitWarning")
def test_the_small_files_are_valid(tmp_path: Path) -> None:
    for small in small_files(tmp_path):
        if small.name == "cut.binary" or small.kind == ENVIRONMENT:
            continue
        for name, content in small.files.items():
            (tmp_path / name).write_bytes(content)
        read = brdfit.read_samples if small.kind == "samples" else brdfit.read_table
        result = read(tmp_path / small.name, format=small.format, **small.options)
        assert isinstance(result, brdfit.Samples | brdfit.Table)


def test_the_same_seed_makes_the_same_mutations() -> None:
    content = bytes(range(256)) * 3
    made = [mutated(content, np.random.default_rng([3, k])) for k in range(50)]
    assert made == [mutated(content, np.random.default_rng([3, k])) for k in range(50)]
    assert sum(item != content for item in made) > 45
    assert len(set(made)) > 45


@pytest.mark.parametrize(
    ("plant", "what"),
    [
        ("crash", "ended by signal 11"),
        ("foreign", "KeyError"),
        ("memory", "MemoryError"),
        ("mute", "an error that says too little"),
        ("warning", "RuntimeWarning"),
    ],
)
def test_what_is_foreign_is_found(plant: str, what: str) -> None:
    status, record = run("--inputs", "3", "--format", "alta", "--plant", plant)
    assert status == 1
    assert len(record["findings"]) == 3
    assert all(what in found["what"] for found in record["findings"])
