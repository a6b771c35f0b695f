"""Pages made from a recorded run: the tables beside the poster's, and what differs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from brdfit.bench.ledger import Record
from brdfit.bench.markdown import Column, table
from brdfit.bench.paper.few_page import few_blocks, posterior_blocks
from brdfit.bench.paper.poster import CITATION, TITLES
from brdfit.bench.paper.summary import Summary
from brdfit.bench.paper.tables import (
    advantage,
    error_table,
    expressiveness,
    real_table,
    sensitivity_table,
    untouched_table,
)
from brdfit.bench.tuning import EVERY

__all__ = ["page"]


def page(
    content: dict[str, Any], figures: dict[str, str], seconds: Mapping[str, float] | None = None
) -> str:
    """Return the page of a result file's content; `figures` maps a figure to its link.

    Known figures: "heat_maps", "outliers", "worst". Parts that were not run are left out.
    `seconds` are those that single records took, by key.
    """
    summary = Summary(content["records"])
    settings = content["settings"]
    blocks = [_opening(content, settings)]
    if summary.part("errors"):
        blocks += _errors(summary, settings, figures)
    if summary.part("few"):
        blocks += few_blocks(summary, seconds or {})
    if summary.part("sensitivity"):
        blocks += _sensitivity(summary)
    if summary.part("expressiveness"):
        blocks += ["## Expressiveness of the correction basis", _EXPRESSIVENESS]
        blocks += [expressiveness(summary)]
    if summary.part("real"):
        blocks += _real(summary.part("real"), settings)
    blocks += ["## What differs from the poster", _DIFFERENCES]
    blocks += ["## The run", _provenance(content)]
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


def _opening(content: dict[str, Any], settings: dict[str, Any]) -> str:
    population = content["population"]
    return f"""# The poster's tables, reproduced

The published method and its rivals ({CITATION}) on the population `{population["name"]}`
({population["members"]} members), every cell computed by `brdfit bench paper` and written by it
from the recorded result. A cell reads *ours / poster's*; "-" is a figure that the poster does
not print. The error is the *perceptual error*: the mean CIEDE2000 over a rendered sphere, as
`brdfit.metrics.perceptual_error` defines it, averaged over the materials, each reconstructed
without itself in the population or in the correction basis. Outlier model:
`{settings["outliers"]}`."""


def _errors(summary: Summary, settings: dict[str, Any], figures: dict[str, str]) -> list[str]:
    _, data_ratios = summary.ratios()
    sparsest = min(data_ratios)
    counts = {record["data_ratio"]: record["samples"] for record in summary.part("errors")}
    blocks = [
        "## Perceptual error by outliers and data",
        f"Mean over {len(summary.materials())} materials. Data ratio 1 is "
        f"{counts[max(data_ratios)]:,} samples, {100 * settings['universe']:g} % of the grid's "
        f"cells, stratified; data ratio {sparsest:g} is {counts[sparsest]:,}.",
    ]
    for method in summary.methods("errors"):
        blocks += [f"### {TITLES.get(method, method)}", error_table(summary, method)]
    if "our" in summary.methods("errors"):
        blocks += [
            "### How many times better",
            f"Mean error of each rival over ours at data ratio {sparsest:g}, ours / poster's.",
            advantage(summary, sparsest),
        ]
        blocks += _untouched(summary, settings, sparsest)
    blocks += posterior_blocks(summary)
    titles = {
        "heat_maps": "The tables as heat maps",
        "outliers": "Error against outlier ratio",
        "worst": "The worst materials beside their references",
    }
    blocks += [f"![{titles[name]}]({link})" for name, link in figures.items()]
    return blocks


def _untouched(summary: Summary, settings: dict[str, Any], data_ratio: float) -> list[str]:
    if settings["materials"]:  # some materials only: which were set apart cannot be told
        return []
    return [
        "### Materials that no constant was chosen on",
        "Constants that the poster leaves open are compared by `brdfit bench sweep`, on every "
        f"{EVERY}rd material in alphabetical order and on no other. Mean error of our method at "
        f"data ratio {data_ratio:g} over all materials, and over those that the sweep never sees.",
        untouched_table(summary, "our", data_ratio),
    ]


def _sensitivity(summary: Summary) -> list[str]:
    return [
        "## Sensitivity to the error metric",
        "All data, no outliers: the poster's logarithmic column repeats that cell of its tables "
        "of errors. The last column is the largest of a row over its smallest.",
        sensitivity_table(summary),
    ]


_EXPRESSIVENESS = """Each correction function C_i, the quotient of a material and its
description by the others, is described in turn by the other correction functions, by least
squares; the deviation is the mean of |C_i - description| over cells that the description was not
fitted to. The poster tells of 99 functions, so each is described by those of its channel; the
method itself uses those of all channels as one basis."""


def _real(records: list[Record], settings: dict[str, Any]) -> list[str]:
    named = {record["method"] for record in records}
    order = [*(name for name in TITLES if name in named), *sorted(named - set(TITLES))]
    return [
        "## Real files",
        f"A random {100 * settings['fraction']:g} % of the usable samples of each file is fitted, "
        f"the rest is predicted: mean |delta ln f| over the rest. The poster's 16 materials are "
        f"not published, and its figures are perceptual errors: the last row shows how its "
        f"methods stood to each other, not a value to be met.",
        real_table(records, order),
    ]


_DIFFERENCES = """\
- **Materials.** The poster reconstructs the measured tables of the MERL database. A population
  of decoded networks or of published fits is smoother: no noise, no lens flare near grazing
  angles, no holes. What interpolates (Tab, Loc) gains most from that, and errors without
  outliers come out lower for every method.
- **Universe.** Data ratio 1 is every cell of the grid on the poster, a stratified share of them
  here unless the run says otherwise. Tab is exact at all cells there and at that share here, so
  that its 0.00 at data ratio 1 without outliers cannot recur.
- **Renderer and error.** The poster names neither the scene nor the measure. Ours is a sphere
  under 40 directional lights and mean CIEDE2000. Absolute figures of different renderers
  do not compare; rows, columns and quotients do.
- **Outliers.** The poster does not say how they were made. `factor` multiplies by a log-uniform
  factor in [1/10, 10]; other models are a word on the command line.
- **Constants.** gamma, damping, the number of iterations, the stopping rule, what "root" is,
  and the bases and smoothness of Glo, Loc and Tab are not printed. Ours are settings of each
  method, recorded below, and not the authors'."""


def _provenance(content: dict[str, Any]) -> str:
    settings, population = content["settings"], content["population"]
    rows = [
        ["command", "`" + content["command"] + "`"],
        ["population", f"{population['name']}, fingerprint `{population['fingerprint'][:16]}`"],
        ["seed", str(settings["seed"])],
        ["grid", " x ".join(str(size) for size in settings["grid"])],
        ["versions", ", ".join(f"{k} {v}" for k, v in sorted(content["versions"].items()))],
    ]
    for name, record in sorted(content["methods"].items()):
        told = ", ".join(f"{key} {value}" for key, value in record.items())
        rows.append([TITLES.get(name, name), told])
    return table([Column("what"), Column("value")], rows)
