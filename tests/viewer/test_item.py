"""One thing that is looked at: what costs time is worked out once, whoever asks."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest

from brdfit.grid import Grid
from brdfit.reconstruct import Reconstruction
from brdfit.report.fitted import Fitted
from brdfit.viewer import item as module
from brdfit.viewer.item import Item


@pytest.fixture
def shown(lobe: Reconstruction) -> Item:
    """Return a fit as if from its files, its table small."""
    fitted = Fitted.of(lobe)
    return Item("e1", "lobe", fitted)


def test_what_is_asked_at_once_by_many_is_worked_out_once(
    shown: Item, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []
    started = threading.Barrier(8)
    real = module.PackedTable.of

    def counted(table: Any) -> Any:
        calls.append(1)
        return real(table)

    monkeypatch.setattr(module.PackedTable, "of", counted)
    found: list[object] = []

    def ask() -> None:
        started.wait()
        found.append(shown.packed)

    threads = [threading.Thread(target=ask) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(calls) == 1
    assert len({id(one) for one in found}) == 1


def test_one_piece_of_work_does_not_wait_for_another(
    shown: Item, monkeypatch: pytest.MonkeyPatch
) -> None:
    go_on, in_time = threading.Event(), []

    def wait(fitted: object) -> tuple[None, None]:
        in_time.append(go_on.wait(5))
        return None, None

    monkeypatch.setattr(module, "drawn_samples", wait)
    slow = threading.Thread(target=shown.ahead)
    slow.start()
    assert shown.packed.shape == Grid(30, 30, 36).shape  # would never come behind the other
    go_on.set()
    slow.join()
    assert in_time == [True]


def test_what_is_worked_out_ahead_is_what_a_slice_draws(
    shown: Item, lobe: Reconstruction, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown.ahead()
    monkeypatch.setattr(module, "drawn_samples", None)
    panel = shown.slice(30.0, 180.0)
    assert {point.sample for point in panel.points} <= set(range(len(lobe.samples)))
    assert np.isfinite(panel.curves[0].value).all()
