"""What became of a fit, in a few lines for a person: from its record, new or kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from brdfit.cli.summary import rows_in_words
from brdfit.report.fit_files import outputs_of

__all__ = ["fit_lines", "kept_fit_lines"]

Record = Mapping[str, Any]


def fit_lines(record: Record) -> list[str]:
    """Return how the fit ended, what it takes for outliers, and the residuals.

    `record` is that of `Reconstruction.record`.
    """
    outcome, outliers, used = record["outcome"], record["outliers"], record["samples"]["usable"]
    plural = "" if record["iterations"] == 1 else "s"
    after = f" after {record['iterations']} iteration{plural}" if record["iterations"] else ""
    count = outliers["count"]
    where = f": {rows_in_words(outliers['rows'])}" if count else ""
    return [
        f"fit by {record['method']['name']}{_leaning(record['population'])}",
        f"  ended       {outcome['name']}{after}. {outcome['advice']}",
        f"  outliers    {count} of {used} samples ({count / max(used, 1):.1%}){where}",
        f"  rule        {outliers['rule']}",
        f"  residuals   median |ln(value / result)| {_course(record['residuals'])}",
    ]


def kept_fit_lines(name: str, record: Record) -> list[str]:
    """Return the same of the record of a fit that was kept as the file called `name`."""
    samples = record["samples"]
    source = samples["source"]
    lines = [
        f"{name}: record of a fit of {source['name']}, {samples['count']:,} samples, "
        f"{len(samples['channels'])} channel{'' if len(samples['channels']) == 1 else 's'}",
        *fit_lines(record),
    ]
    lines += _of_the_table(record)
    versions = ", ".join(f"{part} {version}" for part, version in record["versions"].items())
    return [*lines, f"  made by     {versions}"]


def _of_the_table(record: Record) -> Iterator[str]:
    trust, outputs = record.get("trust"), outputs_of(record)
    # records of before it was kept have no sentence
    albedo = (record.get("albedo") or {}).get("sentence")
    if trust:
        shares = ", ".join(f"{share:.1%} {name}" for name, share in trust["shares"].items())
        yield f"  cells       {shares}"
    if albedo:
        yield f"  albedo      {albedo}"
    if outputs:
        yield f"  files       {', '.join(outputs.values())}"


def _leaning(population: Record) -> str:
    name = population.get("name")
    if not name:
        return ""
    members = population.get("members")
    count = members if isinstance(members, int) else len(members or ())
    return f", leaning on {name}" + (f" ({count} members)" if count else "")


def _course(residuals: Record) -> str:
    before, now, clean = (residuals[key] for key in ("before", "after", "after_without_outliers"))
    # A method without an initial estimate has nothing to be compared with.
    course = _number(now) if before == now else f"{_number(before)} before, {_number(now)} after"
    return f"{course} ({_number(clean)} without the outliers)"


def _number(summary: Record) -> str:
    median = summary["median_abs"]
    return "-" if median is None else f"{median:.3g}"
