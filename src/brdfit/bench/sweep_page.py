"""The page of a sweep, made from its recorded result and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.bench.markdown import Column, cell, table
from brdfit.bench.paper.poster import TITLES
from brdfit.bench.questions import Question, Settings
from brdfit.bench.tuning import EVERY, tuning_materials, untouched_materials

__all__ = ["page"]

_CLEAR = 2.0


@dataclass(frozen=True, eq=False)
class _Row:
    """A candidate and its errors (materials, runs x outlier ratios)."""

    candidate: Settings
    is_default: bool
    errors: FloatArray

    @cached_property
    def mean(self) -> float:
        return float(self.errors.mean())

    @property
    def label(self) -> str:
        return ", ".join(f"{name} {value}" for name, value in self.candidate.items())

    def minus(self, other: _Row) -> tuple[float, float]:
        """Return the mean difference to another over the materials, and its standard error."""
        difference = self.errors.mean(axis=1) - other.errors.mean(axis=1)
        if not np.isfinite(difference).all():  # a picture without an error: nothing is worse
            return float(difference.mean()), 0.0
        count = difference.size
        scatter = float(difference.std(ddof=1)) / np.sqrt(count) if count > 1 else np.inf
        return float(difference.mean()), float(scatter)


@dataclass(frozen=True, eq=False)
class _Answers:
    """The errors of a run by variant, and what was asked."""

    content: dict[str, Any]

    @cached_property
    def ratios(self) -> list[float]:
        return list(self.content["settings"]["outlier_ratios"])

    @cached_property
    def questions(self) -> list[Question]:
        return [
            Question(
                asked["title"],
                asked["method"],
                tuple(asked["candidates"]),
                tuple(asked["metrics"]),
                asked["reason"],
            )
            for asked in self.content["questions"]
        ]

    @cached_property
    def _errors(self) -> dict[tuple[str, str, float], float]:
        return {
            (one["variant"], one["material"], one["outlier_ratio"]): (
                np.inf if one["error"] is None else one["error"]
            )
            for one in self.content["records"]
        }

    def rows(self, question: Question) -> list[_Row]:
        """Return the candidates with their errors."""
        default = self.content["methods"][question.method]
        rows = []
        for candidate in question.candidates:
            runs = question.runs(candidate, default)
            errors = [
                [self._errors[run.key, material, ratio] for run in runs for ratio in self.ratios]
                for material in self.content["materials"]["used"]
            ]
            is_default = all(default[name] == value for name, value in candidate.items())
            rows.append(_Row(candidate, is_default, np.array(errors, dtype=np.float64)))
        return rows


def page(content: dict[str, Any]) -> str:
    """Return the page of a result file's content."""
    answers = _Answers(content)
    blocks = [_opening(content), "## What follows", _overview(answers)]
    for question in answers.questions:
        rows = answers.rows(question)
        blocks += [f"## {question.title}", question.reason, _table(question, rows, answers.ratios)]
        blocks += [_verdict(rows)]
    blocks += ["## Materials", _materials(content["materials"])]
    blocks += ["## The run", _provenance(content)]
    return "\n\n".join(block.strip("\n") for block in blocks if block) + "\n"


def _opening(content: dict[str, Any]) -> str:
    settings, materials = content["settings"], content["materials"]
    ratios = ", ".join(f"{ratio:g}" for ratio in settings["outlier_ratios"])
    samples = content["records"][0]["samples"]
    tuning = len(tuning_materials(materials["all"]))
    return f"""# Constants, compared on materials set apart

Computed by `brdfit bench sweep` and written by it from the recorded result. Constants that the
published method and its rivals leave open are settings with a default. Here the defaults stand
beside other values, on {len(materials["used"])} of the {tuning} materials set apart for that,
each reconstructed without itself from {samples:,} samples (data ratio {settings["data_ratio"]:g})
with outlier ratios {ratios} (`{settings["outliers"]}`).

A cell is the mean perceptual error over the materials. The choice goes by the smallest mean over
the outlier ratios and, where a question is asked under several error metrics, over those, so
that the answer does not hang on the metric. The difference to the default is taken material by
material and stands with its standard error; below {_CLEAR:g} standard errors it is not told from
the scatter of the materials. One material that goes badly wrong widens that scatter: the
records show them one by one."""


def _overview(answers: _Answers) -> str:
    found = []
    for question in answers.questions:
        rows = answers.rows(question)
        best, default = _best(rows), _default(rows)
        beside = "-" if default is None else default.label
        figures = cell(best.mean, None if default is None else default.mean)
        found.append([question.title, best.label, beside, figures, _standing(best, default)])
    columns = [Column("question"), Column("smallest mean"), Column("default")]
    return table([*columns, Column("their errors", True), Column("the default is")], found)


def _table(question: Question, rows: list[_Row], ratios: list[float]) -> str:
    metrics = [f"{metric} " for metric in question.metrics] or [""]
    names = list(rows[0].candidate)
    columns = [Column(""), *(Column(name, True) for name in names)]
    columns += [Column(f"{metric}{ratio:g}", True) for metric in metrics for ratio in ratios]
    columns += [Column("mean", True), Column("minus default", True)]
    best, default = _best(rows), _default(rows)
    found = []
    for row in rows:
        line = ["default" if row.is_default else ""]
        line += [str(row.candidate[name]) for name in names]
        line += [cell(value) for value in row.errors.mean(axis=0)]
        line += [cell(row.mean, bold=row is best), _difference(row, default)]
        found.append(line)
    return table(columns, found)


def _difference(row: _Row, default: _Row | None) -> str:
    if default is None or row is default:
        return "-"
    mean, scatter = row.minus(default)
    return f"{mean:+.3f} ± {scatter:.3f}"


def _best(rows: list[_Row]) -> _Row:
    """Return the row of the smallest mean; of equals the default."""
    return min(rows, key=lambda row: (row.mean, not row.is_default))


def _default(rows: list[_Row]) -> _Row | None:
    return next((row for row in rows if row.is_default), None)


def _standing(best: _Row, default: _Row | None) -> str:
    if default is None:
        return "not among the values"
    if best is default:
        return "the smallest"
    mean, scatter = default.minus(best)
    return "not to be told from it" if mean <= _CLEAR * scatter else "clearly larger"


def _verdict(rows: list[_Row]) -> str:
    best, default = _best(rows), _default(rows)
    if default is None or best is default:
        told = f"Smallest mean: {best.label}" + (", the default." if default else ".")
    else:
        mean, scatter = default.minus(best)
        told = (
            f"Smallest mean: {best.label}. The default, {default.label}, lies {mean:.3f} ± "
            f"{scatter:.3f} above it: {_standing(best, default)}."
        )
    edges = _at_the_edge(rows, best)
    if edges:
        told += f" It is at the edge of what was tried ({', '.join(edges)}); beyond may be better."
    return told


def _at_the_edge(rows: list[_Row], best: _Row) -> list[str]:
    """Return the settings of which `best` has the least or the largest of three values or more."""
    found = []
    for name, value in best.candidate.items():
        tried = {row.candidate[name] for row in rows}
        ordered = all(isinstance(one, int | float) for one in tried) and len(tried) > 2
        if ordered and value in (min(tried), max(tried)):
            found.append(name)
    return found


def _materials(materials: dict[str, list[str]]) -> str:
    tuning, untouched = tuning_materials(materials["all"]), untouched_materials(materials["all"])
    used = set(materials["used"])
    named = ", ".join(f"**{name}**" if name in used else name for name in tuning)
    return f"""Set apart for choosing constants, every {EVERY}rd in alphabetical order, those used
here bold ({len(tuning)}): {named}.

To be untouched by the choice, a reported figure leaves those out and is a mean over the other
{len(untouched)}: {", ".join(untouched)}."""


def _provenance(content: dict[str, Any]) -> str:
    population = content["population"]
    rows = [
        ["command", "`" + content["command"] + "`"],
        ["population", f"{population['name']}, fingerprint `{population['fingerprint'][:16]}`"],
        ["seed", str(content["settings"]["seed"])],
        ["universe", f"{100 * content['settings']['universe']:g} % of the grid's cells"],
        ["versions", ", ".join(f"{k} {v}" for k, v in sorted(content["versions"].items()))],
    ]
    for name, record in sorted(content["methods"].items()):
        told = ", ".join(f"{key} {value}" for key, value in record.items())
        rows.append([f"defaults of {TITLES.get(name, name)}", told])
    return table([Column("what"), Column("value")], rows)
