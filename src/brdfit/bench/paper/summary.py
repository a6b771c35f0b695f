"""Averages over materials of the records of a run."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.bench.ledger import Record
from brdfit.bench.paper.poster import TITLES

__all__ = ["Summary"]


@dataclass(frozen=True, eq=False)
class Summary:
    """The records of a run by part."""

    records: Sequence[Record]

    def part(self, name: str) -> list[Record]:
        """Return the records of one part."""
        return [record for record in self.records if record["part"] == name]

    @cached_property
    def _errors(self) -> dict[tuple[str, float, float], list[Record]]:
        found: dict[tuple[str, float, float], list[Record]] = {}
        for record in self.part("errors"):
            cell = (record["method"], record["outlier_ratio"], record["data_ratio"])
            found.setdefault(cell, []).append(record)
        return found

    def methods(self, part: str) -> list[str]:
        """Return the methods of a part, in the order in which the tables show them."""
        seen = {record["method"] for record in self.part(part)}
        return [*(name for name in TITLES if name in seen), *sorted(seen - set(TITLES))]

    @cached_property
    def _few(self) -> dict[tuple[str, int, str, float], list[Record]]:
        found: dict[tuple[str, int, str, float], list[Record]] = {}
        for record in self.part("few"):
            cell = (record["method"], record["samples"], record["outliers"])
            found.setdefault((*cell, record["outlier_ratio"]), []).append(record)
        return found

    def few_rows(self) -> list[tuple[int, str]]:
        """Return (samples, outlier model) of the tables of few samples, most samples first."""
        return sorted({cell[1:3] for cell in self._few}, key=lambda row: (-row[0], row[1]))

    def few_ratios(self) -> list[float]:
        """Return the outlier ratios of the tables of few samples, ascending."""
        return sorted({cell[3] for cell in self._few})

    def few(self, method: str, row: tuple[int, str], outlier_ratio: float) -> list[Record]:
        """Return the records of a cell of few samples, one a material."""
        return self._few.get((method, *row, outlier_ratio), [])

    def errors(self, method: str, outlier_ratio: float, data_ratio: float) -> FloatArray:
        """Return the perceptual errors of a cell, one a material; empty where it was not run.

        NaN is a fit that was refused.
        """
        records = self._errors.get((method, outlier_ratio, data_ratio), [])
        return np.array([record["error"] for record in records], dtype=np.float64)

    def mean(
        self,
        method: str,
        outlier_ratio: float,
        data_ratio: float,
        among: Collection[str] | None = None,
    ) -> float | None:
        """Return the mean perceptual error of a cell, None where it was not run or refused.

        `among` are the materials that count; None is all.
        """
        records = self._errors.get((method, outlier_ratio, data_ratio), [])
        errors = [one["error"] for one in records if among is None or one["material"] in among]
        if not errors or None in errors:
            return None
        return float(np.mean(np.array(errors, dtype=np.float64)))

    def ratios(self) -> tuple[list[float], list[float]]:
        """Return (outlier ratios ascending, data ratios descending) of the run."""
        cells = self._errors.keys()
        return sorted({cell[1] for cell in cells}), sorted(
            {cell[2] for cell in cells}, reverse=True
        )

    def worst(self, method: str, outlier_ratio: float, data_ratio: float, count: int) -> list[str]:
        """Return the materials with the largest errors of a cell, worst first."""
        records = self._errors.get((method, outlier_ratio, data_ratio), [])
        records = [record for record in records if record["error"] is not None]
        ranked = sorted(records, key=lambda record: (-record["error"], record["material"]))
        return [record["material"] for record in ranked[:count]]

    def materials(self) -> list[str]:
        """Return the materials that were reconstructed, alphabetically."""
        return sorted({record["material"] for record in self.part("errors")})

    def sensitivity(self, method: str) -> dict[str, float]:
        """Return the mean perceptual error by error metric: all data, no outliers.

        The metric of the tables of errors was made there, the others in a part of their own.
        """
        found: dict[str, list[float]] = {}
        tabled = [record for record in self.part("errors") if record["outlier_ratio"] == 0.0]
        most = max((record["data_ratio"] for record in tabled), default=0.0)
        tabled = [record for record in tabled if record["data_ratio"] == most]
        for record in [*self.part("sensitivity"), *tabled]:
            if record["method"] == method and record["metric"] is not None:
                found.setdefault(record["metric"], []).append(record["error"])
        return {metric: float(np.mean(errors)) for metric, errors in found.items()}

    def expressiveness(self, name: str = "deviation") -> FloatArray:
        """Return the deviations, one a material; or "deviation_by_all"."""
        return np.array([record[name] for record in self.part("expressiveness")], float)
