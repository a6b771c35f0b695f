"""The page of a recorded run: the same job by everybody, then stage by stage."""

from __future__ import annotations

from typing import Any

from brdfit.bench.ledger import Record
from brdfit.bench.markdown import Column, cell, table
from brdfit.bench.speed.stages import JOB, RIVALS

__all__ = ["page"]

# What was to be reached: times faster than each rival, and a dense RGB table over its bytes.
_FASTER, _OVER_MEMORY = 50.0, 2.5
_DENSE = {"dense_rgb": "`Posterior`", "dense_compact": "`Compact`"}
_BATCH = "batch_"


def page(content: dict[str, Any]) -> str:
    """Return the page of a result file's content."""
    records = {record["stage"]: record for record in content["records"]}
    what = content["settings"]["stages"]
    blocks = [_OPENING, "## Stages", _STAGES, _stage_table(records, what)]
    if JOB in records:
        blocks += ["## The same job", _same_job(records[JOB]), _job_table(records, what)]
    if any(name.startswith(_BATCH) for name in records):
        blocks += ["## Many items", _batch_meaning(content), _batch_table(records, what)]
    blocks += ["## What was to be reached", _aims(records)]
    blocks += ["## Left out", *missing] if (missing := _missing(records)) else []
    blocks += ["## The run", _provenance(content, records)]
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


_OPENING = """# Speed

Made by `brdfit bench speed`. Every stage runs in a process of its own, one after the other;
seconds are the median of its runs, after one that is not counted (the basis is in the cache, as
at any fit but the first). The measurements are made by the program, of a material that the fits
do not lean on, with 2 % noise and a fifth of the samples spoilt."""

_STAGES = """*Floor*: the longer of the bytes that must be read or written, each once, at the
bandwidth of copying a large block, and the operations that cannot be left out at the rate of a
matrix product, both measured in the same process just before. Of a fit that is one round: what
it repeats, it repeats. Disks are not counted. Memory is the peak of the process and, of it, what
came on top of what was held before."""


def _stage_table(records: dict[str, Record], what: dict[str, str]) -> str:
    columns = [Column("stage"), Column("size"), Column("seconds", True)]
    columns += [Column("processor s", True), Column("peak MB", True), Column("added MB", True)]
    columns += [Column("floor, s", True), Column("over floor", True), Column("bounded by")]
    rows = [
        [
            what[name],
            _size(record),
            _seconds(record["median"]),
            _seconds(record["processor"]),
            str(record["peak_mb"]),
            str(record["added_mb"]),
            f"{record['floor']:.2g}",
            _times(record["over_floor"]),
            "memory" if record["memory_floor"] >= record["product_floor"] else "products",
        ]
        for name, record in records.items()
        if "floor" in record and name not in (JOB, *RIVALS)
    ]
    return table(columns, rows)


def _size(record: Record) -> str:
    for name in ("items", "samples", "directions"):
        if name in record:
            return f"{record[name]:,} {name}"
    return "-"


def _same_job(record: Record) -> str:
    return (
        f"{record.get('samples', 0):,} RGB samples in, {record.get('cells', 0):,} cells of the "
        f"MERL grid out. Both rivals interpolate ln f_r over the same coordinates; the process "
        f"optimises an amplitude, four lengths and a noise. *Error* is the mean |delta ln f| over "
        f"all cells against what the samples were made from, a material that is like those leaned "
        f"on: only the posterior knows of any, or asks whether a sample is wrong."
    )


def _job_table(records: dict[str, Record], what: dict[str, str]) -> str:
    own = records[JOB].get("median")
    own_processor = records[JOB].get("processor")
    columns = [Column("by"), Column("seconds", True), Column("times ours", True)]
    columns += [Column("processor s", True), Column("times ours", True)]
    columns += [Column("peak MB", True), Column("error", True)]
    rows = [
        [
            what[name],
            _seconds(record["median"]),
            _times(record["median"] / own),
            _seconds(record["processor"]),
            _times(record["processor"] / own_processor),
            str(record["peak_mb"]),
            cell(record["error"]),
        ]
        for name, record in records.items()
        if name in (JOB, *RIVALS) and "median" in record
    ]
    return table(columns, rows)


def _batch_meaning(content: dict[str, Any]) -> str:
    settings = content["settings"]
    return (
        f"{settings['items']:,} items of {settings['per_item']} RGB samples, blends of two "
        f"materials, a fifth of the samples spoilt. The loop has the same components, asks no "
        f"sample whether it is wrong, and states no uncertainty."
    )


def _batch_table(records: dict[str, Record], what: dict[str, str]) -> str:
    columns = [Column("by"), Column("items/s", True), Column("peak MB", True)]
    rows = [
        [what[name], f"{record['items_a_second']:,.0f}", str(record["peak_mb"])]
        for name, record in records.items()
        if "items_a_second" in record
    ]
    return table(columns, rows)


def _aims(records: dict[str, Record]) -> str:
    columns = [Column("what"), Column("aim"), Column("measured", True)]
    rows = []
    own = records.get(JOB, {}).get("median")
    for name in RIVALS:
        other = records.get(name, {}).get("median")
        faster = other / own if own and other else None
        reached = faster is not None and faster >= _FASTER
        rows.append(
            [
                f"`Posterior`, the same job: times faster than {name.removeprefix('job_')}",
                f"at least {_FASTER:g}",
                cell(faster, digits=1, bold=reached),
            ]
        )
    for name, method in _DENSE.items():
        over = records.get(name, {}).get("over_memory")
        rows.append(
            [
                f"dense RGB table from a finished fit, {method}, over the time of its bytes",
                f"at most {_OVER_MEMORY:g}",
                cell(over, digits=2, bold=over is not None and over <= _OVER_MEMORY),
            ]
        )
    return "A figure in bold is reached.\n\n" + table(columns, rows)


def _missing(records: dict[str, Record]) -> list[str]:
    return [f"`{name}`: {r['left_out']}" for name, r in records.items() if "left_out" in r]


def _provenance(content: dict[str, Any], records: dict[str, Record]) -> str:
    rates = {
        name: [record[name] for record in records.values() if name in record]
        for name in ("bandwidth", "single", "double")
    }
    machine = content["machine"]
    loads = [load for record in records.values() if (load := record.get("load")) is not None]
    lines = [
        ("command", f"`{content['command']}`"),
        ("seed", str(content["seed"])),
        ("population", content["settings"]["population"]),
        ("processor", f"{machine['processor']}, {machine['cpus']} cores, {machine['platform']}"),
        ("threads of the linear algebra", str(machine["threads"])),
        *([("load as stages began", f"{min(loads)} to {max(loads)}")] if loads else []),
        ("bandwidth, GB/s", _range(rates["bandwidth"])),
        ("products, float32, GFlop/s", _range(rates["single"])),
        ("products, float64, GFlop/s", _range(rates["double"])),
        ("versions", ", ".join(f"{k} {v}" for k, v in sorted(content["versions"].items()))),
        *((name, f"sha256 {digest[:16]}") for name, digest in sorted(content["inputs"].items())),
    ]
    return table([Column("what"), Column("value")], lines)


def _range(rates: list[float]) -> str:
    return f"{min(rates) / 1e9:.1f} to {max(rates) / 1e9:.1f}" if rates else "-"


def _seconds(value: float) -> str:
    return f"{value:.1f}" if value >= 10.0 else f"{value:.3f}"


def _times(value: float) -> str:
    return f"{value:,.0f}" if value >= 10.0 else f"{value:.2f}"
