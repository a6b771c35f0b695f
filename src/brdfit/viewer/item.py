"""`Item`: one thing that can be looked at, and everything the page may ask of it.

Items are frozen: a refit makes a new one, so what one tab does never changes what another
tab sees. What costs time is worked out when it is first asked for, once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from brdfit.albedo import directional_albedo
from brdfit.arrays import BoolArray, FloatArray
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.coverage import Reach
from brdfit.report.drawn import drawn_samples, stddev_of
from brdfit.report.fitted import Fitted
from brdfit.report.packed_table import PackedTable
from brdfit.report.rgb import Conversion, rgb_table
from brdfit.report.slice_panel import SlicePanel, slice_panel
from brdfit.report.uncertainty import NORMAL_95
from brdfit.samples import Samples
from brdfit.table import Table

__all__ = ["Item"]

_ALBEDO_COSINE = np.linspace(0.02, 1.0, 40)
_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class Item:
    """A table or a reconstruction, under a name and an id."""

    id: str
    name: str
    fitted: Fitted
    result: Reconstruction | None = None
    """The fit itself, if it was made in this session."""
    source: Path | None = None
    """The file of the measurements, to show a row as it stands there."""
    warnings: tuple[str, ...] = ()
    parent: str | None = None
    """Id of the item that this is a refit of."""
    _made: dict[str, Any] = field(default_factory=dict, repr=False)
    _locks: dict[str, Any] = field(default_factory=dict, repr=False)
    _lock: Any = field(default_factory=threading.Lock, repr=False)

    @property
    def kind(self) -> str:
        """Return "reconstruction" where samples are known, else "table"."""
        return "table" if self.fitted.judged is None else "reconstruction"

    @property
    def table(self) -> Table:
        """The dense result with all its channels."""
        return self.fitted.table

    @property
    def rgb(self) -> Table:
        """The table as it is shown."""
        return self.in_colour[0]

    @property
    def in_colour(self) -> tuple[Table, Conversion]:
        """The table as it is shown, and how it came to its colours."""
        return self.once("in_colour", lambda: rgb_table(self.table))

    @property
    def packed(self) -> PackedTable:
        """The table as it travels."""
        return self.once("packed", lambda: PackedTable.of(self.rgb))

    @property
    def albedo(self) -> tuple[FloatArray, FloatArray]:
        """(cosine (k,), directional albedo (k, 3)): what an even surround adds."""
        return self.once("albedo", lambda: (_ALBEDO_COSINE, _albedo(self.rgb)))

    @property
    def reach(self) -> Reach | None:
        """How far any direction is from a sample; None where no samples are known."""
        judged = self.fitted.judged
        return None if judged is None else self.once("reach", lambda: Reach(judged.samples))

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels): of the fit where it is at hand, else of the table."""
        return (self.table if self.result is None else self.result).evaluate(wi, wo)

    @cached_property
    def stddev(self) -> Callable[[FloatArray, FloatArray], FloatArray] | None:
        """The standard deviation of ln f_r in the channels of the samples, if it is stated."""
        if self.result is not None:
            up = np.array([[0.0, 0.0, 1.0]])
            known = self.result.model.stddev(up, up) is not None
            return self.result.stddev if known else None
        stated = self.fitted.uncertainty
        return None if stated is None else stated.evaluate

    @property
    def deviations(self) -> float:
        """How many `stddev`, to either side, hold 95 %."""
        if self.result is not None:
            return self.result.deviations(0.95)
        stated = self.fitted.uncertainty
        return NORMAL_95 if stated is None else stated.deviations_95

    @property
    def no_band(self) -> str:
        """Why there is no band; empty where there is one."""
        if self.stddev is not None:
            return ""
        if self.result is None and not self.fitted.record:
            return "a table alone states no uncertainty"
        return "the method states no uncertainty"

    def slice(self, theta_i: float, phi: float) -> SlicePanel:
        """Return the slice at angles in degrees, with the band and the samples nearby."""
        angles = {"theta_i": theta_i, "phi": phi, "deviations": self.deviations}
        if self.result is not None:
            result = self.result
            return slice_panel(result, result.samples, result.outliers, self.stddev, **angles)
        samples, outliers = self._drawn
        return slice_panel(self.table, samples, outliers, stddev_of(self.fitted), **angles)

    @property
    def _drawn(self) -> tuple[Samples | None, BoolArray | None]:
        return self.once("drawn", lambda: drawn_samples(self.fitted))

    def ahead(self) -> None:
        """Work out what the page asks for next: bands take their time to become R, G, B."""
        if self.result is None:
            _ = self._drawn

    @property
    def record(self) -> dict[str, Any]:
        """The record of the fit; empty if it is not known."""
        return dict(self.fitted.record)

    def once(self, name: str, make: Callable[[], _T]) -> _T:
        """Return what `make` made the first time that `name` was asked for."""
        # Two tabs that ask at once wait for one piece of work, not for two, nor for another.
        with self._lock:
            lock = self._locks.setdefault(name, threading.Lock())
        with lock:
            if name not in self._made:
                self._made[name] = make()
            made: _T = self._made[name]
            return made


def _albedo(rgb: Table) -> FloatArray:
    return directional_albedo(rgb, np.arccos(_ALBEDO_COSINE), rings=64, spokes=8)
