"""What the posterior is to reach on real files, and how far it is from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.bench.ledger import Record
from brdfit.bench.markdown import Column, cell, table

__all__ = ["RBF", "Cells", "aims_table", "columns_that_aim"]

RBF = "log_rbf"
GLOBAL = "global"
POSTERIOR = "posterior"

_CLEAN = ("100", "1000")


@dataclass(frozen=True, eq=False)
class Cells:
    """The records of a run by condition, file and column."""

    every: Sequence[Record]

    @cached_property
    def _by(self) -> dict[str, dict[str, dict[str, Record]]]:
        found: dict[str, dict[str, dict[str, Record]]] = {}
        for record in self.every:
            files = found.setdefault(record["condition"], {})
            files.setdefault(record["file"], {})[record["method"]] = record
        return found

    def files(self, condition: str) -> list[str]:
        """Return the files that have a condition, sorted."""
        return sorted(self._by.get(condition, {}))

    def of(self, condition: str, file: str) -> dict[str, Record]:
        """Return the records of a condition and file by column."""
        return self._by[condition][file]

    def records(self, condition: str, name: str) -> list[tuple[str, Record]]:
        """Return (file, record) of a condition and column, sorted by file."""
        return [
            (file, self._by[condition][file][name])
            for file in self.files(condition)
            if name in self._by[condition][file]
        ]

    def states_intervals(self, name: str) -> bool:
        """Return whether a column states how sure it is."""
        return any(record["method"] == name and "within_68" in record for record in self.every)

    def mean(self, condition: str, name: str, title: str) -> float | None:
        """Return the mean of a figure over the files that have it."""
        return _mean([record.get(title) for _, record in self.records(condition, name)])

    def error(self, condition: str, file: str, name: str) -> float | None:
        """Return the mean |delta ln f| of one fit, None where it was not run or refused."""
        record = self._by.get(condition, {}).get(file, {}).get(name, {})
        return record.get("mean")

    def pairs(
        self, one: tuple[str, str], other: tuple[str, Sequence[str]]
    ) -> list[tuple[float, float]]:
        """Return the errors of (condition, column) beside the lowest of other columns, by file."""
        found = []
        for file in self.files(one[0]):
            own = self.error(one[0], file, one[1])
            rivals = [self.error(other[0], file, name) for name in other[1]]
            known = [value for value in rivals if value is not None]
            if own is not None and len(known) == len(rivals):
                found.append((own, min(known)))
        return found


def columns_that_aim(cells: Cells, methods: Sequence[str]) -> list[str]:
    """Return the columns of the posterior, with whatever population."""
    seen = {record["method"] for record in cells.every}
    return [name for name in methods if name.split(":")[0] == POSTERIOR and name in seen]


def aims_table(cells: Cells, names: Sequence[str]) -> str:
    """Return the table of aims: what, how much, and the figures of each column."""
    lines = [(what, aim, [_line(cells, name, key) for name in names]) for key, what, aim in _AIMS]
    rows = [
        [what, f"{_WORD[aim[0]]} {aim[1]:g}", *(_told(value, aim) for value in values)]
        for what, aim, values in lines
    ]
    return table([Column("what"), Column("aim"), *(Column(name, True) for name in names)], rows)


Aim = tuple[str, float]
_WORD = {"most": "at most", "near 0.06": "within 0.06 of", "near 0.03": "within 0.03 of"}

_AIMS: tuple[tuple[tuple[str, str], str, Aim], ...] = (
    *(
        line
        for count in _CLEAN
        for line in (
            (
                ("mean", count),
                f"{count} samples, mean error over that of the better",
                ("most", 0.88),
            ),
            (("worst", count), f"{count} samples, the same on the worst file", ("most", 1.03)),
        )
    ),
    (("spoilt", "1000:factor"), "1000:factor, error over that without outliers", ("most", 1.25)),
    (("rbf", "1000:factor"), f"1000:factor, error over that of `{RBF}`", ("most", 0.5)),
    *(
        line
        for count in _CLEAN
        for line in (
            (("flagged", count), f"{count} samples, named as outliers, mean", ("most", 0.02)),
            (("within_68", count), f"{count} samples, within 68 %, mean", ("near 0.06", 0.68)),
            (("within_95", count), f"{count} samples, within 95 %, mean", ("near 0.03", 0.95)),
        )
    ),
)


def _line(cells: Cells, name: str, key: tuple[str, str]) -> float | None:
    kind, condition = key
    if kind in {"mean", "worst"}:
        pairs = cells.pairs((condition, name), (condition, (RBF, GLOBAL)))
        if not pairs:
            return None
        ratios = [own / best for own, best in pairs]
        return max(ratios) if kind == "worst" else _quotient(pairs)
    if kind == "spoilt":
        return _quotient(cells.pairs((condition, name), (condition.split(":")[0], (name,))))
    if kind == "rbf":
        return _quotient(cells.pairs((condition, name), (condition, (RBF,))))
    return cells.mean(condition, name, kind)


def _quotient(pairs: Sequence[tuple[float, float]]) -> float | None:
    """Return the mean of the first of each pair over the mean of the second."""
    return sum(one for one, _ in pairs) / sum(other for _, other in pairs) if pairs else None


def _told(value: float | None, aim: Aim) -> str:
    if value is None:
        return "-"
    kind, goal = aim
    reached = value <= goal if kind == "most" else abs(value - goal) <= float(kind.split()[1])
    return cell(value, bold=reached)


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
