"""The figures of a run: heat maps, error against outlier ratio, the worst spheres."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.bench.paper.poster import DATA_RATIOS, ERRORS, OUTLIER_RATIOS, TITLES
from brdfit.bench.paper.summary import Summary
from brdfit.files import atomic_path

__all__ = ["heat_maps", "outlier_curves", "worst_spheres"]

_LOWEST, _HIGHEST = 0.1, 50.0
_COLOURS = {"our": "#1b6ca8", "glo": "#c25b12", "loc": "#3f8f3f", "tab": "#8a3b8f"}


def heat_maps(summary: Summary, path: Path) -> None:
    """Draw each method's table, ours above the poster's, on one logarithmic scale."""
    methods = summary.methods("errors")
    outlier_ratios, data_ratios = summary.ratios()
    figure, axes = _subplots(2, len(methods), 2.7 * len(methods) + 0.8, 5.6)
    for column, method in enumerate(methods):
        ours = [[summary.mean(method, o, d) for d in data_ratios] for o in outlier_ratios]
        title = TITLES.get(method, method)
        _heat_map(axes[0][column], ours, outlier_ratios, data_ratios, f"{title}, brdfit")
        printed = ERRORS.get(method)
        if printed is None:
            axes[1][column].set_axis_off()
        else:
            _heat_map(axes[1][column], printed, OUTLIER_RATIOS, DATA_RATIOS, f"{title}, poster")
    _label_outer(axes, "data ratio", "outlier ratio")
    _save(figure, path)


def _heat_map(
    axis: Any,
    values: Sequence[Sequence[float | None]],
    rows: Sequence[float],
    columns: Sequence[float],
    title: str,
) -> None:
    from matplotlib.colors import LogNorm

    array = np.array(values, dtype=np.float64)
    shown = np.clip(array, _LOWEST, _HIGHEST)
    axis.imshow(shown, norm=LogNorm(_LOWEST, _HIGHEST), cmap="viridis_r", aspect="auto")
    for (row, column), value in np.ndenumerate(array):
        colour = "black" if value < 3.0 else "white"
        axis.text(column, row, f"{value:.2f}", ha="center", va="center", color=colour, fontsize=8)
    axis.set_xticks(range(len(columns)), [f"{ratio:g}" for ratio in columns], fontsize=8)
    axis.set_yticks(range(len(rows)), [f"{ratio:g}" for ratio in rows], fontsize=8)
    axis.set_title(title, fontsize=10)


def outlier_curves(summary: Summary, data_ratio: float, path: Path) -> None:
    """Draw mean error against outlier ratio with the spread over materials, the poster dashed."""
    outlier_ratios, _ = summary.ratios()
    figure, axes = _subplots(1, 1, 6.4, 4.4)
    axis = axes[0][0]
    for index, method in enumerate(summary.methods("errors")):
        colour = _COLOURS.get(method, f"C{index}")
        errors = [summary.errors(method, o, data_ratio) for o in outlier_ratios]
        low, high = np.array([np.percentile(one, [10.0, 90.0]) for one in errors]).T
        title = TITLES.get(method, method)
        axis.fill_between(outlier_ratios, low, high, color=colour, alpha=0.15, linewidth=0)
        axis.plot(outlier_ratios, [one.mean() for one in errors], "o-", color=colour, label=title)
        if method in ERRORS and data_ratio in DATA_RATIOS:
            printed = [row[DATA_RATIOS.index(data_ratio)] for row in ERRORS[method]]
            axis.plot(OUTLIER_RATIOS, printed, "--", color=colour, linewidth=1.2)
    axis.set_yscale("log")
    axis.set_xlabel("outlier ratio")
    axis.set_ylabel("perceptual error (mean CIEDE2000)")
    axis.set_title(
        f"data ratio {data_ratio:g}; band: 10th to 90th percentile of materials; dashed: poster",
        fontsize=9,
    )
    axis.grid(True, which="both", alpha=0.25)
    axis.legend(fontsize=9)
    _save(figure, path)


def worst_spheres(
    pictures: Sequence[tuple[str, FloatArray, FloatArray]], title: str, path: Path
) -> None:
    """Draw (caption, reference, reconstruction): linear images (size, size, channels) in pairs.

    Both of a pair are exposed as the perceptual error does it: 0.8 over the 95th percentile
    of the reference's disk.
    """
    from brdfit.tone import exposure_scale, srgb_encode, three_channels

    figure, axes = _subplots(2, len(pictures), 2.1 * len(pictures), 4.8)
    for column, (caption, reference, test) in enumerate(pictures):
        scale = exposure_scale(reference, np.asarray((reference > 0.0).any(axis=2)))
        for row, image in enumerate((reference, test)):
            axis = axes[row][column]
            axis.imshow(srgb_encode(three_channels(image) * scale), interpolation="nearest")
            axis.set_xticks([])
            axis.set_yticks([])
        axes[0][column].set_title(caption, fontsize=8)
    axes[0][0].set_ylabel("reference", fontsize=9)
    axes[1][0].set_ylabel("reconstruction", fontsize=9)
    figure.suptitle(title, fontsize=10)
    _save(figure, path)


def _subplots(rows: int, columns: int, width: float, height: float) -> tuple[Any, Any]:
    # The object-oriented interface: no window system, no global state of pyplot.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False)


def _label_outer(axes: Any, x: str, y: str) -> None:
    for axis in axes[-1]:
        axis.set_xlabel(x, fontsize=9)
    for row in axes:
        row[0].set_ylabel(y, fontsize=9)


def _save(figure: Any, path: Path) -> None:
    with atomic_path(path) as aside:
        figure.savefig(aside, dpi=120)
