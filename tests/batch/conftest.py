"""Tables and an undisturbed run, made once."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from small_batch import BLOCK, columns, method, write_parquet

from brdfit.batch import open_input, run_batch

ITEMS = 700


@pytest.fixture(scope="session")
def table(tmp_path_factory):
    """Return a Parquet table of 700 items in the same directions."""
    return write_parquet(tmp_path_factory.mktemp("batch") / "patch.parquet", columns(ITEMS))


@pytest.fixture(scope="session")
def store(table):
    """Return the store of the table, of one undisturbed run."""
    path = table.with_name("patch.zarr")
    run_batch(open_input(table), path, method(), block=BLOCK)
    return path
