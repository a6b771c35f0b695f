"""The page of `batch.py`."""

from __future__ import annotations

import os
from typing import Any

from brdfit.bench.markdown import Column, table

Record = dict[str, Any]


def page(result: Record) -> str:
    """Return the result as a page of tables."""
    parts = result["parts"]
    blocks = [
        "# Very many items",
        "Made by `python benchmarks/batch.py`. 64 RGB samples an item, a fifth of them wrong, on a "
        "synthetic patch mixed from decoded networks; population `embedded`, default settings, "
        f"{result['cores']} cores that other work may have shared.",
    ]
    for name, title, tables in (
        ("speed", "Speed", _speed),
        ("accuracy", "Accuracy", _accuracy),
        ("memory", "Memory", _memory),
        ("kills", "Killed and continued", _kills),
        ("dask", "Dask", _dask),
        ("torch", "Another array library", _torch),
    ):
        if name in parts:
            blocks += [f"## {title}", tables(parts[name])]
    return "\n\n".join(blocks) + "\n"


def _speed(found: dict[str, Any]) -> str:
    two = found["workers_2"]
    rows = [
        [
            name,
            f"{found[key]['a_second']:,.1f}",
            f"{found[key]['a_core']:,.1f}",
            f"{two['a_core'] / found[key]['a_core']:,.1f}",
        ]
        for name, key in (
            (f"`run_batch`, two processes, {found['items']:,} items", "workers_2"),
            (f"`run_batch`, one process, {found['items'] // 4:,} items", "workers_1"),
            ("`Compact.fit_block`, directions shared", "core"),
            ("`Compact.fit_block`, own directions", "core_own_directions"),
            ("a loop of `Compact().fit`", "loop_of_single_fits"),
            ("a loop of `Posterior().fit`", "loop_of_posterior"),
        )
    ]
    note = (
        f"Load of the machine when it began: {found['load']:.1f} on {os.cpu_count()} cores. *A "
        "core*: items a second of processor time, all processes and their start included."
    )
    columns = [Column("who"), Column("a second", True), Column("a core", True)]
    return table([*columns, Column("ratio", True)], rows) + "\n" + note


def _accuracy(found: Record) -> str:
    rows = []
    for name in ("embedded", "other networks"):
        of = found[name]
        rows += [
            [f"{name}: {label}", f"{of[key]['mean']:.4f}", f"{of[key]['p90']:.4f}"]
            for label, key in (
                ("many at once", "together"),
                ("one by one", "one_by_one"),
                ("`Posterior`", "posterior"),
            )
        ]
        far = of["together_from_one_by_one"]
        rows.append([f"{name}: at most between the first two", f"{far:g}", ""])
    return table([Column("mean abs delta ln f"), Column("mean", True), Column("p90", True)], rows)


def _memory(found: Record) -> str:
    rows = [
        [f"{int(count):,}", str(run["peak_mb"]), f"{run['seconds']:,.0f}"]
        for count, run in found.items()
        if count.isdigit()
    ]
    columns = [Column("items"), Column("peak MB", True), Column("seconds", True)]
    note = (
        f"`brdfit batch --workers {found['workers']} --memory 1GB`: all its processes together, "
        "their shared pages counted once (proportional set size), asked ten times a second."
    )
    return note + "\n\n" + table(columns, rows)


def _kills(found: Record) -> str:
    done = [f"{count:,}" for count in found["done_after_each"]]
    return (
        f"{found['items']:,} items in {found['blocks']} blocks, two workers. SIGKILL "
        f"{found['kills_while_starting']} times while the run starts "
        f"({found['done_after_those']:,} items done after those), then {found['kills']} times at "
        "random moments between its first block and its last, each run continuing the last. "
        f"Items done after each of the {found['kills']}: {', '.join(done)}. The store is "
        + ("byte for byte that" if found["identical"] else "NOT that")
        + " of an undisturbed run."
    )


def _dask(found: Record) -> str:
    rows = [
        [f"{n} single-threaded", f"{found[f'workers_{n}']:,.0f}"]
        for n in (1, 2)
        if f"workers_{n}" in found
    ]
    kept = "the same, no item lost" if found["identical"] else "NOT the same"
    return (
        table([Column("workers"), Column("items a second, once they run", True)], rows)
        + f"\n\nTwo are {found['ratio']:.2f} times one. One of two killed with SIGKILL in the "
        f"middle of {found['items']:,} items: the store is {kept}."
    )


def _torch(found: Record) -> str:
    columns = [Column("a block of items"), Column("numpy, items/s", True)]
    columns += [Column("torch, items/s", True), Column("torch / numpy", True)]
    columns += [Column("most between them, ln f_r", True)]
    rows = [
        [
            name,
            f"{of['numpy']:,.0f}",
            f"{of['torch']:,.0f}",
            f"{of['torch'] / of['numpy']:.2f}",
            f"{of['most_apart']:.1e}",
        ]
        for name, of in found["blocks"].items()
    ]
    note = (
        f"`Compact.fit_block(block, basis, to=torch.from_numpy)`, PyTorch {found['version']} on "
        f"the processor, {found['items']:,} items, one thread, items a second of processor time: "
        "the code that a GPU would run. No GPU figure was taken: none was at hand."
    )
    return note + "\n\n" + table(columns, rows)
