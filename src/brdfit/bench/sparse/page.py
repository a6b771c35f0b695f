"""The page of a recorded run: a table a metric, the published figures beside, what differs."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np

from brdfit.bench.markdown import Column, table
from brdfit.bench.sparse.cases import IMAGE_METRICS
from brdfit.bench.sparse.published import CITATION, HYPERBRDF

__all__ = ["means", "page"]

_TITLES = {
    "psnr": "PSNR of displayed spheres, dB (higher is better)",
    "perceptual_error": "Perceptual error: mean CIEDE2000 (lower is better)",
    "ssim": "SSIM of displayed spheres (higher is better)",
}
_DIGITS = {"psnr": 2, "perceptual_error": 3, "ssim": 4}

Means = dict[tuple[str, int, str], float]
"""(method, samples, metric) -> mean over materials and draws."""


def means(records: list[dict[str, Any]]) -> Means:
    """Return the means of the cells in which no fit was refused."""
    found: dict[tuple[str, int, str], list[float | None]] = defaultdict(list)
    for record in records:
        for metric in IMAGE_METRICS:
            found[record["method"], record["samples"], metric].append(record[metric])
    return {
        cell: float(np.mean([value for value in values if value is not None]))
        for cell, values in found.items()
        if None not in values
    }


def page(content: dict[str, Any]) -> str:
    """Return the page of a result file's content."""
    figures = means(content["records"])
    blocks = [_opening(content)]
    for metric in IMAGE_METRICS:
        blocks += [f"## {_TITLES[metric]}", _table(content, figures, metric)]
    blocks += _aims(content, figures)
    blocks += ["## What differs from the published figures", _DIFFERENCES]
    blocks += ["## The run", _provenance(content)]
    return "\n\n".join(block.strip("\n") for block in blocks) + "\n"


def _opening(content: dict[str, Any]) -> str:
    settings, lean_on = content["settings"], content["lean_on"]
    return f"""# Few samples of materials that were held out

Made by `brdfit bench sparse`. The {len(settings["held_out"])} materials of the published test
split of the meta-sampling code (Liu, Fischer, Ritschel 2023) are taken from the population
`{content["population"]["name"]}` and reconstructed by every method, with its default settings,
from N samples without noise at directions uniform over the Rusinkiewicz angles. Methods that
lean on a population lean on `{lean_on["name"]}` without the held-out materials
({lean_on["members"]} members). Figures are means over the materials and
{settings["repeats"]} draws of directions each, the same samples for every method, of spheres of
{settings["image_size"]} x {settings["image_size"]} pixels under the studio, over the disk. The
best of our columns is bold; "-" means that a method refused one of the cases, or that nothing
was published. The last two columns are {CITATION}, learnt from 80 MERL materials, and from
these and 51 of the RGL database."""


def _table(content: dict[str, Any], figures: Means, metric: str) -> str:
    methods = list(content["methods"])
    rows = []
    for count in content["settings"]["samples"]:
        own = {name: figures.get((name, count, metric)) for name in methods}
        known = [value for value in own.values() if value is not None]
        better = min if metric == "perceptual_error" else max
        best = better(known) if known else None
        cells = [
            _cell(value, metric, value is not None and value == best) for value in own.values()
        ]
        printed = [column.get(count, {}).get(metric) for column in HYPERBRDF.values()]
        rows.append([str(count), *cells, *(_cell(value, metric) for value in printed)])
    titles = [*methods, *(f"HyperBRDF, {learnt}" for learnt in HYPERBRDF)]
    return table([Column("N", True), *(Column(title, True) for title in titles)], rows)


def _aims(content: dict[str, Any], figures: Means) -> list[str]:
    """Return the section that holds the posterior against what it is to reach."""
    if not {"posterior", "pca_ridge"} <= set(content["methods"]):
        return []
    rows = []
    for count in content["settings"]["samples"]:
        one, other = (
            figures.get((name, count, "perceptual_error")) for name in ("posterior", "pca_ridge")
        )
        published = HYPERBRDF["MERL"].get(count, {}).get("perceptual_error")
        cells = []
        for rival, aim in ((other, 1.0), (published, 0.5)):
            ratio = one / rival if one is not None and rival else None
            reached = ratio is not None and ratio <= aim
            cells.append(
                "-" if ratio is None else f"**{ratio:.3f}**" if reached else f"{ratio:.3f}"
            )
        rows.append([str(count), *cells])
    titles = ("posterior / pca_ridge", "posterior / HyperBRDF, MERL")
    return [
        "## What the posterior is to reach",
        "Set before it was built: a smaller perceptual error than `pca_ridge` at every N, and at "
        "N = 40 at most half of what HyperBRDF published. Quotients; bold is at or below 1, and "
        "0.5 beside HyperBRDF.",
        table([Column("N", True), *(Column(title, True) for title in titles)], rows),
    ]


def _cell(value: float | None, metric: str, bold: bool = False) -> str:
    text = "-" if value is None else f"{value:.{_DIGITS[metric]}f}"
    return f"**{text}**" if bold else text


_DIFFERENCES = """\
- **Materials.** HyperBRDF's own 80/20 split is not published; the one used here is that of
  another paper, which can be computed again from its code. The references here are the networks
  or tables of the population named below; HyperBRDF's are the measured MERL tables, which have
  noise, holes and flare near grazing angles. Decoded networks are smoother, and that makes
  reconstructing them easier for every method here.
- **Renders.** HyperBRDF renders in Mitsuba under an environment map; map, resolution, peak of
  the PSNR and tone mapping are not stated. Here a sphere under 40 directional lights, exposed by
  the reference, with the sRGB curve; what lies beside the sphere is not counted, which makes
  every figure worse than one over the whole picture.
- **Samples.** Uniform over the angles in both. HyperBRDF does not say how many draws its figures
  are means over.

So the published columns say in which region a learnt method lies, not who wins by how much."""


def _provenance(content: dict[str, Any]) -> str:
    rows = [
        ["command", f"`{content['command']}`"],
        ["population", _named(content["population"])],
        ["leant on", _named(content["lean_on"])],
        ["seed", str(content["settings"]["seed"])],
        ["versions", ", ".join(f"{k} {v}" for k, v in sorted(content["versions"].items()))],
    ]
    for name, record in sorted(content["methods"].items()):
        told = ", ".join(f"{key} {value}" for key, value in record.items() if key != "name")
        rows.append([name, told])
    return table([Column("what"), Column("value")], rows)


def _named(population: dict[str, Any]) -> str:
    name, members = population["name"], population["members"]
    return f"{name}, {members} members, fingerprint `{population['fingerprint'][:16]}`"
