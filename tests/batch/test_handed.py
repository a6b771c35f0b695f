"""What workers are started with."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from brdfit.batch.handed import Handed

HELD: list[Handed] = []


def receive(handed: Handed) -> None:
    """Keep what this process was started with."""
    HELD.append(handed)


def describe() -> tuple[dict[str, object], bool]:
    """Return what it is, and whether it could be written."""
    value = HELD[0].value
    return value, value["rows"].flags.writeable


def test_every_worker_has_what_was_handed_over_and_none_can_change_it():
    value = {"rows": np.arange(30_000.0).reshape(3, -1), "few": np.eye(3, dtype="f4"), "name": "x"}
    context = multiprocessing.get_context("spawn")
    with Handed(value) as handed, ProcessPoolExecutor(2, context, receive, (handed,)) as pool:
        for future in [pool.submit(describe) for _ in range(4)]:
            found, writeable = future.result()
            assert not writeable
            assert found["name"] == "x"
            assert np.array_equal(found["rows"], value["rows"])
            assert found["few"].dtype == np.float32
            assert np.array_equal(found["few"], value["few"])
