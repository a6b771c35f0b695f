"""The poster's tables as Markdown, its figure beside ours in every cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brdfit.bench.ledger import Record
from brdfit.bench.markdown import Column, cell, table
from brdfit.bench.paper.poster import (
    DATA_RATIOS,
    ERRORS,
    EXPRESSIVENESS,
    OUTLIER_RATIOS,
    REAL_AVERAGE,
    SENSITIVITY,
    TITLES,
)
from brdfit.bench.paper.settings import METRICS
from brdfit.bench.paper.summary import Summary
from brdfit.bench.tuning import untouched_materials

__all__ = [
    "advantage",
    "error_table",
    "expressiveness",
    "real_table",
    "sensitivity_table",
    "untouched_table",
]


def error_table(summary: Summary, method: str) -> str:
    """Return the table of one method: outlier ratios down, data ratios across."""
    outlier_ratios, data_ratios = summary.ratios()
    columns = [Column("outliers \\ data"), *(Column(f"{ratio:g}", True) for ratio in data_ratios)]
    rows = [
        [
            f"{outliers:.2f}",
            *(
                cell(
                    summary.mean(method, outliers, data),
                    _printed(method, outliers, data),
                    digits=2,
                )
                for data in data_ratios
            ),
        ]
        for outliers in outlier_ratios
    ]
    return table(columns, rows)


def advantage(summary: Summary, data_ratio: float) -> str:
    """Return how many times larger the others' mean error is than ours, ours and the poster's."""
    outlier_ratios, _ = summary.ratios()
    others = [name for name in summary.methods("errors") if name != "our"]
    columns = [Column("outliers"), *(Column(f"{_title(name)} / Our", True) for name in others)]
    rows = []
    for outliers in outlier_ratios:
        row = [f"{outliers:.2f}"]
        for name in others:
            ours = _over(
                summary.mean(name, outliers, data_ratio), summary.mean("our", outliers, data_ratio)
            )
            theirs = _over(
                _printed(name, outliers, data_ratio), _printed("our", outliers, data_ratio)
            )
            row.append(cell(ours, theirs, digits=1))
        rows.append(row)
    return table(columns, rows)


def untouched_table(summary: Summary, method: str, data_ratio: float) -> str:
    """Return the errors over all materials beside those that no constant was chosen on.

    The run must hold every material of the population: which are which goes by their order.
    """
    every = summary.materials()
    others = untouched_materials(every)
    columns = [Column("outliers"), *(Column(f"{len(x)} materials", True) for x in (every, others))]
    rows = [
        [
            f"{outliers:.2f}",
            *(
                cell(summary.mean(method, outliers, data_ratio, among), digits=2)
                for among in (every, others)
            ),
        ]
        for outliers in summary.ratios()[0]
    ]
    return table(columns, rows)


def sensitivity_table(summary: Summary) -> str:
    """Return the table of sensitivity to the error metric."""
    columns = [
        Column("method"),
        *(Column(metric, True) for metric in METRICS),
        Column("largest / smallest", True),
    ]
    rows = []
    for method in summary.methods("sensitivity"):
        found, printed = summary.sensitivity(method), SENSITIVITY.get(method, {})
        cells = [cell(found.get(metric), printed.get(metric), digits=2) for metric in METRICS]
        spread = cell(_spread(found), _spread(printed), digits=2)
        rows.append([_title(method), *cells, spread])
    return table(columns, rows)


def expressiveness(summary: Summary) -> str:
    """Return the table of the expressiveness of the correction basis."""
    columns = [Column("described by"), *(Column(x, True) for x in ("mean", "median", "largest"))]
    rows = []
    for what, name, printed in (
        ("the other functions of its channel", "deviation", EXPRESSIVENESS),
        ("those of all channels", "deviation_by_all", None),
    ):
        found = summary.expressiveness(name)
        figures = [np.median(found), found.max()]
        rows.append([what, cell(found.mean(), printed), *(cell(float(x)) for x in figures)])
    return table(columns, rows)


def real_table(records: Sequence[Record], names: Sequence[str]) -> str:
    """Return the table of real files: mean |delta ln f| of the samples that were not fitted."""
    by_file: dict[str, dict[str, float | None]] = {}
    for record in records:
        by_file.setdefault(record["file"], {})[record["method"]] = record["mean"]
    columns = [Column("material"), *(Column(_title(name), True) for name in names)]
    rows = [
        [file, *(cell(found.get(name), bold=_is_lowest(found, name)) for name in names)]
        for file, found in sorted(by_file.items())
    ]
    means: dict[str, float | None] = {}
    for name in names:
        known = [value for found in by_file.values() if (value := found.get(name)) is not None]
        means[name] = float(np.mean(known)) if len(known) == len(by_file) else None
    rows.append(["**mean**", *(cell(means[name], bold=_is_lowest(means, name)) for name in names)])
    rows.append(["poster, its own 16", *(cell(REAL_AVERAGE.get(name), digits=2) for name in names)])
    return table(columns, rows)


def _is_lowest(found: dict[str, float | None], name: str) -> bool:
    known = [value for value in found.values() if value is not None]
    return bool(known) and found.get(name) == min(known)


def _title(name: str) -> str:
    return TITLES.get(name, name)


def _printed(method: str, outliers: float, data: float) -> float | None:
    if method not in ERRORS or outliers not in OUTLIER_RATIOS or data not in DATA_RATIOS:
        return None
    return ERRORS[method][OUTLIER_RATIOS.index(outliers)][DATA_RATIOS.index(data)]


def _over(one: float | None, other: float | None) -> float | None:
    return None if one is None or not other else one / other


def _spread(found: dict[str, float]) -> float | None:
    return max(found.values()) / min(found.values()) if found else None
