"""The blocks of the page that tell of few samples, and of the posterior beside the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from brdfit.bench.ledger import Record
from brdfit.bench.markdown import Column, cell, table
from brdfit.bench.paper.poster import TITLES
from brdfit.bench.paper.settings import FewRow
from brdfit.bench.paper.summary import Summary

__all__ = ["AIMS", "few_blocks", "posterior_blocks"]

POSTERIOR = "post"

AIMS: dict[FewRow, dict[float, float]] = {
    (110_000, "factor"): {0.0: 0.06, 0.2: 0.06, 0.4: 0.07, 0.6: 0.10, 0.8: 0.25},
    (1000, "factor"): {0.0: 0.18, 0.2: 0.20, 0.4: 0.22, 0.6: 0.32, 0.8: 0.70},
    (1000, "uniform"): {0.0: 0.18, 0.2: 0.20, 0.4: 0.22, 0.6: 0.25, 0.8: 0.32},
    (100, "factor"): {0.0: 0.40, 0.2: 0.45, 0.4: 0.52, 0.6: 0.80, 0.8: 2.5},
    (100, "uniform"): {0.0: 0.40, 0.2: 0.43, 0.4: 0.47, 0.6: 0.70, 0.8: 0.95},
}
"""Mean perceptual error that the posterior is to reach, set before it was built."""

_NAMED_AIM = "at 0.4 `factor`: precision at least 0.95, recall at least 0.9"


def few_blocks(summary: Summary, seconds: Mapping[str, float]) -> list[str]:
    """Return the section of few samples; `seconds` are those of single fits, by record."""
    materials = len({record["material"] for record in summary.part("few")})
    blocks = [
        "## Few samples",
        f"Mean perceptual error over {materials} materials, each from samples at random cells of "
        "the grid (several draws of cells, each material has one of them). Outlier ratios across. "
        "The lowest of a column is bold; *aim* is what the posterior was to reach, set before it "
        "was built. '-' is a cell in which a fit was refused.",
    ]
    for row in summary.few_rows():
        blocks += [f"### {row[0]:,} samples, `{row[1]}`", _few_table(summary, row)]
    judging = _judging(summary.part("few"))
    for name in judging:
        blocks += [f"### Outliers that {_title(name)} named", _NAMING]
        blocks += [_named_table(summary, name, seconds)]
    return blocks


_NAMING = f"""A planted outlier is *beyond* if it was moved by more than three times the noise of a
good sample, as the fit found it. Precision: planted among the named. Recall: named among those
beyond. Flagged: named among all. Means over the materials in which there are any. Aim,
{_NAMED_AIM}. Seconds are those of a fit, without the dense result, as many side by side as the
run had workers."""


def _few_table(summary: Summary, row: FewRow) -> str:
    ratios = summary.few_ratios()
    names = summary.methods("few")
    means = {(n, ratio): _error(summary.few(n, row, ratio)) for n in names for ratio in ratios}
    rows = [
        [_title(name), *(_bold(means, names, name, ratio) for ratio in ratios)] for name in names
    ]
    if row in AIMS:
        rows.append(["*aim*", *(cell(AIMS[row].get(ratio), digits=2) for ratio in ratios)])
    return table([Column("method"), *(Column(f"{ratio:g}", True) for ratio in ratios)], rows)


def _bold(
    means: Mapping[tuple[str, float], float | None], names: Sequence[str], name: str, ratio: float
) -> str:
    known = [value for one in names if (value := means[one, ratio]) is not None]
    value = means[name, ratio]
    return cell(value, digits=2, bold=value is not None and value == min(known))


def _named_table(summary: Summary, name: str, seconds: Mapping[str, float]) -> str:
    titles = ("precision", "recall", "flagged", "noise", "seconds")
    columns = [Column("samples"), Column("outliers", True), *(Column(t, True) for t in titles)]
    rows = []
    for row in summary.few_rows():
        for ratio in summary.few_ratios():
            records = summary.few(name, row, ratio)
            if not records:
                continue
            rows.append(
                [
                    f"{row[0]:,} {row[1]}",
                    f"{ratio:g}",
                    *(cell(_mean(records, key)) for key in titles[:4]),
                    cell(_mean_seconds(records, seconds), digits=2),
                ]
            )
    return table(columns, rows)


def posterior_blocks(summary: Summary) -> list[str]:
    """Return the section that sets the posterior against the best of the others, cell by cell."""
    names = summary.methods("errors")
    others = [name for name in names if name != POSTERIOR]
    if POSTERIOR not in names or not others:
        return []
    outlier_ratios, data_ratios = summary.ratios()
    rows, ahead, count = [], 0, 0
    for outliers in outlier_ratios:
        row = [f"{outliers:.2f}"]
        for data in data_ratios:
            own = summary.mean(POSTERIOR, outliers, data)
            rivals = {
                name: value
                for name in others
                if (value := summary.mean(name, outliers, data)) is not None
            }
            if own is None or not rivals:
                row.append("-")
                continue
            best = min(rivals, key=lambda name: rivals[name])
            count, ahead = count + 1, ahead + (own <= rivals[best])
            text = f"{own:.3f} / {rivals[best]:.3f} {_title(best)}"
            row.append(f"**{text}**" if own <= rivals[best] else text)
        rows.append(row)
    columns = [Column("outliers \\ data"), *(Column(f"{ratio:g}", True) for ratio in data_ratios)]
    return [
        "### The posterior beside the best of the others",
        f"Posterior / best other, and which. Bold, {ahead} of {count}: at or below it.",
        table(columns, rows),
    ]


def _judging(records: Sequence[Record]) -> list[str]:
    return sorted({record["method"] for record in records if "precision" in record})


def _error(records: Sequence[Record]) -> float | None:
    errors = [record["error"] for record in records]
    return float(np.mean(errors)) if errors and None not in errors else None


def _mean(records: Sequence[Record], name: str) -> float | None:
    found = [record[name] for record in records if record.get(name) is not None]
    return float(np.mean(found)) if found else None


def _mean_seconds(records: Sequence[Record], seconds: Mapping[str, float]) -> float | None:
    found = [seconds[record["key"]] for record in records if record["key"] in seconds]
    return float(np.mean(found)) if found else None


def _title(name: str) -> str:
    return TITLES.get(name, name)
