"""Dask does the work, and may lose a worker."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from small_batch import content

pytest.importorskip("distributed", reason="needs dask: pip install 'brdfit[cluster]'")
SCRIPT = Path(__file__).with_name("small_batch.py")


def test_a_worker_of_the_cluster_that_is_killed_costs_nothing(tmp_path, table, store):
    # A process of its own: Dask's event loops and warnings are not those of the tests.
    path = tmp_path / "out.zarr"
    words = [sys.executable, str(SCRIPT), str(table), str(path), "dask"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["11", "11"]  # every block once
    assert content(path) == content(store)


def test_a_scheduler_that_does_not_answer_is_named(tmp_path, table):
    code = (
        "from brdfit.cli import main; import sys; "
        f"sys.exit(main(['batch', {str(table)!r}, '-o', {str(tmp_path / 'o.zarr')!r}, "
        "'--scheduler', 'tcp://127.0.0.1:9']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "tcp://127.0.0.1:9" in done.stderr
    assert "dask scheduler" in done.stderr
