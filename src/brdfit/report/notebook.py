"""What a notebook shows of samples, a table or a result: a small picture, its key figures."""

from __future__ import annotations

from html import escape

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import BoolArray
from brdfit.errors import UsageError
from brdfit.reconstruct.result import Reconstruction
from brdfit.render import ForDisplay, Sphere, point
from brdfit.report.coverage import coverage_of
from brdfit.report.page.pictures import cut_out, png_uri
from brdfit.report.page.svg import Plot, Scale
from brdfit.report.page.words import count, number, percent
from brdfit.samples import Samples
from brdfit.table import Table
from brdfit.tone import display_image, exposure_scale

__all__ = ["html_of"]

_SIZE = 120
_MOST_DOTS = 2_000
# Within the box only, and in the notebook's own colour of text: dark and light alike.
_STYLE = (
    ".brdfit-shown{display:flex;flex-wrap:wrap;gap:1rem;align-items:center}"
    ".brdfit-shown svg{width:260px}"
    ".brdfit-shown svg text{fill:currentColor;font:11px system-ui,sans-serif}"
    ".brdfit-shown .grid{stroke:currentColor;opacity:.2}"
    ".brdfit-shown .mark{fill:#2f78c4;opacity:.7}"
    ".brdfit-shown .outlier{fill:none;stroke:#c2309f;stroke-width:1.6}"
    ".brdfit-shown dl{display:grid;grid-template-columns:auto 1fr;gap:.1rem .8rem;margin:0}"
    # JupyterLab floats and narrows the parts of a list
    ".brdfit-shown dl>dt,.brdfit-shown dl>dd"
    "{float:none;width:auto;margin:0;padding:0;font-weight:normal}"
    ".brdfit-shown dl>dt{opacity:.7}"
)


def html_of(what: object) -> str:
    """Return HTML that shows samples, a table or a result; everything in it is escaped."""
    if isinstance(what, Samples):
        return _box(what.source.name, [_dots(what)], _about_samples(what))
    if isinstance(what, Table):
        return _box(what.source.name, [_sphere(what, what)], _about_table(what))
    if isinstance(what, Reconstruction):
        pictures = [_sphere(what, what.samples), _dots(what.samples, what.outliers)]
        return _box(what.samples.source.name, pictures, _about_result(what))
    raise UsageError(f"a notebook is shown samples, tables and results; found {type(what)!r}.")


def _box(name: str, pictures: list[str], figures: list[tuple[str, str]]) -> str:
    lines = "".join(f"<dt>{escape(key)}</dt><dd>{escape(value)}</dd>" for key, value in figures)
    return (
        f'<div class="brdfit-shown"><style>{_STYLE}</style>{"".join(pictures)}'
        f"<div><strong>{escape(name)}</strong><dl>{lines}</dl></div></div>"
    )


def _sphere(brdf: Evaluable, bands: Samples | Table) -> str:
    sphere = Sphere(_SIZE)
    linear = sphere.shade(ForDisplay.of(brdf, bands.wavelengths, bands.channels), point())
    try:
        scale = exposure_scale(linear, sphere.mask)
    except UsageError:
        return ""
    uri = png_uri(cut_out(display_image(linear, scale)))
    return f'<img src="{uri}" width="{_SIZE}" height="{_SIZE}" alt="a sphere, one point light">'


def _dots(samples: Samples, outliers: BoolArray | None = None) -> str:
    used = np.flatnonzero(samples.usable.any(axis=1))
    if used.size == 0:
        return ""
    used = used[:: max(1, -(-used.size // _MOST_DOTS))]
    theta_h, theta_d, _ = (np.degrees(angle[used]) for angle in samples.half_diff)
    ticks = tuple((t, f"{t:g}") for t in (0.0, 5.0, 15.0, 30.0, 60.0, 90.0))
    plot = Plot(
        Scale(0.0, 90.0, ticks, "theta_h, degrees", "root"),
        Scale.linear(0.0, 90.0, (0, 30, 60, 90), "theta_d, degrees"),
        "where the measurements lie in half/difference coordinates",
        size=(300, 200),
    )
    wrong = np.zeros(len(samples), bool) if outliers is None else np.asarray(outliers, bool)
    wrong = wrong[used]
    plot.marks(theta_h[~wrong], theta_d[~wrong], "mark", size=1.6)
    plot.marks(theta_h[wrong], theta_d[wrong], "outlier", cross=True)
    return plot.markup()


def _about_samples(samples: Samples) -> list[tuple[str, str]]:
    used = int(samples.usable.any(axis=1).sum())
    lines = [
        ("samples", f"{count(len(samples))}, {count(used)} usable"),
        ("channels", _names(samples.channels)),
    ]
    coverage = coverage_of(samples)
    if coverage is not None:
        lines.append(("coverage", f"{percent(coverage.share)} of the domain within 5°"))
    flags = ", ".join(
        f"{count(n)} {name.replace('_', ' ')}" for name, n in samples.flag_counts().items()
    )
    return [*lines, ("flagged", flags or "none")]


def _about_table(table: Table) -> list[tuple[str, str]]:
    n_h, n_d, n_phi = table.grid.shape
    valid = table.values[table.mask]
    lines = [
        ("table", f"{n_h} × {n_d} × {n_phi} nodes"),
        ("channels", _names(table.channels)),
        ("cells", f"{count(int(table.mask.sum()))} valid, {count(table.missing)} missing"),
    ]
    if valid.size:
        lines.append(("f_r", f"{number(float(valid.min()))} to {number(float(valid.max()))} 1/sr"))
    return lines


def _about_result(result: Reconstruction) -> list[tuple[str, str]]:
    used = int(result.samples.usable.any(axis=1).sum())
    wrong = int(result.outliers.sum())
    size = np.abs(result.residuals[~result.outliers])
    size = size[np.isfinite(size)]
    lines = [
        ("method", f"{result.method.name}, {result.outcome.value.replace('_', ' ')}"),
        ("outliers", f"{count(wrong)} of {count(used)} samples"),
    ]
    if size.size:
        lines.append(("misfit", f"{percent(float(np.expm1(np.median(size))))} (median)"))
    if result.population.get("name"):
        lines.append(("leans on", str(result.population["name"])))
    if not result.outcome.ok:
        lines.append(("look at this", result.outcome.advice))
    return lines


def _names(channels: tuple[str, ...]) -> str:
    if len(channels) <= 4:
        return ", ".join(channels)
    return f"{len(channels)}, {channels[0]} to {channels[-1]}"
