"""`brdfit view`, as it is typed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.grid import Grid
from brdfit.table import Table

pytest.importorskip("starlette", reason="the viewer needs the extra: pip install 'brdfit[viewer]'")


@pytest.fixture
def table_npz(tmp_path: Path) -> Path:
    path = tmp_path / "grey.npz"
    brdfit.write_table(Table(values=np.full((8, 8, 8, 3), 0.1), grid=Grid(8, 8, 8)), path)
    return path


@pytest.mark.parametrize(
    ("ending", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_it_prints_the_address_serves_and_ends_when_asked(
    table_npz: Path, tmp_path: Path, ending: signal.Signals, code: int
) -> None:
    words = [sys.executable, "-m", "brdfit", "view", str(table_npz), "--no-browser"]
    private = tmp_path / "private"
    private.mkdir()
    program = subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(private)},
    )
    try:
        assert program.stdout is not None
        found = next(filter(None, (re.match(r"http://\S+", line) for line in program.stdout)))
        with urllib.request.urlopen(f"{found[0]}api/home", timeout=20) as answer:
            assert b'"entries":["e1"]' in answer.read()
        assert len(list(private.iterdir())) == 1
        program.send_signal(ending)
        _, errors = program.communicate(timeout=20)
    finally:
        program.kill()
        program.wait()
    assert "Traceback" not in errors
    assert program.returncode == code
    # what was uploaded lay there
    assert list(private.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["gone.binary"], 1, "there is no such file"),
        (["--prot", "80"], 2, "Did you mean --port?"),
        (["--port", "123456"], 2, "expected 0 to 65535"),
        (["--method", "corection"], 2, "Did you mean correction?"),
    ],
)
def test_what_cannot_be_shown_is_said_and_nothing_is_served(
    run: Callable[..., Any], words: list[str], code: int, told: str
) -> None:
    ended = run("view", *words, "--no-browser")
    assert ended.code == code
    assert told in ended.err


def test_a_port_that_is_taken_is_named(run: Callable[..., Any]) -> None:
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        ended = run("view", "--no-browser", "--port", taken.getsockname()[1])
    assert ended.code == 2
    assert "cannot be used" in ended.err
