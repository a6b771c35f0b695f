"""The page of a recorded run: a table a condition, and what was to be reached beside it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from brdfit.bench.holdout.aims import RBF, Cells, aims_table, columns_that_aim
from brdfit.bench.holdout.conditions import BLIND, SHARE, SPOILT
from brdfit.bench.holdout.seen import unseen
from brdfit.bench.ledger import Record
from brdfit.bench.markdown import Column, cell, table

__all__ = ["RBF", "page"]


def page(content: dict[str, Any]) -> str:
    """Return the page of a result file's content."""
    cells = Cells(content["records"])
    settings = content["settings"]
    methods = list(settings["methods"])
    blocks = [_opening(content)]
    aiming = columns_that_aim(cells, methods)
    if aiming:
        blocks += ["## What the posterior is to reach", _AIMS, aims_table(cells, aiming)]
        others = unseen(cells)
        if others.every and len(others.every) < len(cells.every):
            blocks += [_UNSEEN, aims_table(others, aiming)]
    for condition in settings["conditions"]:
        files = cells.files(condition)
        if files:
            blocks += [f"## {_title(condition)}", _meaning(condition, settings)]
            blocks += [_error_table(cells, condition, files, methods)]
    for name in methods:
        if cells.states_intervals(name):
            blocks += [f"## Intervals and outliers of `{name}`", _INTERVALS]
            blocks += [_interval_table(cells, name, settings["conditions"])]
    blocks += ["## The run", _provenance(content)]
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


def _opening(content: dict[str, Any]) -> str:
    return f"""# Real files: a part fitted, the rest predicted

Made by `brdfit bench holdout`. Of each material a part of the usable samples is fitted with each
method's default settings, the rest is predicted. A cell of a table is the median and the mean of
|delta ln f| over the held-out values above zero, all channels together; the lowest mean of a row
is bold. Held-out values that are zero or negative are censored: they have no logarithm, are left
out, and counted in their column. `{RBF}` is SciPy's RBF interpolator through ln f, its kernel,
smoothing and scale chosen by five-fold cross-validation inside the fitted part only. A method
that leans on a population leans on the default one unless another is named behind the colon."""


_AIMS = f"""Set before the posterior was built. *Better* is the better of `{RBF}` and `global` on
each file. Means are over the files that have the condition; a figure in bold is reached."""

_UNSEEN = """The same over the files that none of the posterior's constants was chosen on:"""

_INTERVALS = """Share of the held-out measurements within the 68 % and the 95 % interval that the
method states, the noise of a measurement included; the median standard deviation of ln f_r; the
share of the fitted samples that it named as outliers, and of those planted how many were named
(recall, of those moved by more than three times the noise) and how many of the named were planted
(precision)."""


def _title(condition: str) -> str:
    if condition == SHARE:
        return "A share of each file"
    if condition == BLIND:
        return "Blind regions"
    count, _, model = condition.partition(":")
    return f"{int(count):,} samples" + (
        f", {SPOILT:.0%} of them `{model}` outliers" if model else ""
    )


def _meaning(condition: str, settings: dict[str, Any]) -> str:
    if condition == SHARE:
        share = 100 * settings["fraction"]
        return f"A random {share:g} % of the usable samples is fitted."
    if condition == BLIND:
        return (
            "The samples are put into four bands of incidence angle with about as many each; the "
            "second and the fourth are left out whole and predicted, at most 1,000 of the others "
            "are fitted. Reciprocity alone tells of some of what was left out."
        )
    return (
        "Drawn at random, the same for all methods. Files with fewer than a quarter more usable "
        "samples are left out."
    )


def _error_table(cells: Cells, condition: str, files: list[str], methods: Sequence[str]) -> str:
    rows = [_row(name, cells.of(condition, name), methods) for name in files]
    groups = sorted({name.split("/")[0] for name in files})
    for group in groups:
        inside = [cells.of(condition, name) for name in files if name.startswith(f"{group}/")]
        rows.append(_mean_row(f"**{group}, mean of {len(inside)}**", inside, methods))
    every = [cells.of(condition, name) for name in files]
    rows.append(_mean_row(f"**all, mean of {len(files)}**", every, methods))
    columns = [Column("material"), *(Column(t, True) for t in ("samples", "fitted", "compared"))]
    columns += [Column("censored", True), *(Column(name, True) for name in methods)]
    return table(columns, rows)


def _row(name: str, found: dict[str, Record], methods: Sequence[str]) -> list[str]:
    first = next(iter(found.values()))
    compared = max(record.get("compared", 0) for record in found.values())
    censored = max(record.get("censored", 0) for record in found.values())
    counts = [str(first["samples"]), str(first["fitted"]), str(compared), str(censored)]
    return [name, *counts, *_figures(found, methods)]


def _mean_row(title: str, cases: list[dict[str, Record]], methods: Sequence[str]) -> list[str]:
    means: dict[str, Record] = {}
    for name in methods:
        whole = [found[name] for found in cases if found.get(name, {}).get("mean") is not None]
        if len(whole) == len(cases):
            means[name] = {
                part: sum(record[part] for record in whole) / len(whole)
                for part in ("median", "mean")
            }
    return [title, "", "", "", "", *_figures(means, methods)]


def _figures(found: dict[str, Record], methods: Sequence[str]) -> list[str]:
    means = {name: found.get(name, {}).get("mean") for name in methods}
    known = [mean for mean in means.values() if mean is not None]
    return [
        cell(found.get(name, {}).get("median"), means[name], bold=means[name] == min(known))
        if means[name] is not None
        else "-"
        for name in methods
    ]


def _interval_table(cells: Cells, name: str, conditions: Sequence[str]) -> str:
    titles = ("within_68", "within_95", "stddev", "noise", "flagged", "precision", "recall")
    heads = ("68 %", "95 %", *titles[2:])
    columns = [Column("material"), Column("fitted"), *(Column(head, True) for head in heads)]
    rows = []
    for condition in conditions:
        records = cells.records(condition, name)
        for file, record in records:
            rows.append([file, condition, *(cell(record.get(title)) for title in titles)])
        if records:
            means = [cells.mean(condition, name, title) for title in titles]
            rows.append([f"**mean of {len(records)}**", condition, *(cell(x) for x in means)])
    return table(columns, rows)


def _provenance(content: dict[str, Any]) -> str:
    rows = [
        ["command", f"`{content['command']}`"],
        ["seed", str(content["seed"])],
        ["files", f"{len(content['inputs'])}, their hashes in the record"],
        ["versions", ", ".join(f"{k} {v}" for k, v in sorted(content["versions"].items()))],
    ]
    for name, record in content["settings"]["methods"].items():
        told = {key: value for key, value in record.items() if key != "fingerprint"}
        rows.append([name, ", ".join(f"{key} {value}" for key, value in told.items())])
    return table([Column("what"), Column("value")], rows)
