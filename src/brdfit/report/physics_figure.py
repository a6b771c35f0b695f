"""The picture of a health check: the directional albedo against the furnace, and the findings."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

from brdfit.files import atomic_path
from brdfit.physics import Health, Verdict

__all__ = ["draw_health"]

_INK = "#222222"
_COLOUR = {
    Verdict.GOOD: "#2f7d32",
    Verdict.LOOK: "#b26a00",
    Verdict.WRONG: "#c62828",
    Verdict.UNKNOWN: "#777777",
}
_CHANNEL = {"R": "#c62828", "G": "#2f7d32", "B": "#1e5bb8"}
_COLUMNS = 62


def draw_health(health: Health, name: str, path: Path) -> None:
    """Write a PNG of 1300 x 620 pixels of the findings about the file `name`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 6.2), dpi=100, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(5, 6))
    _albedo(left, health)
    _findings(right, health)
    figure.suptitle(f"{name} ({health.kind})", color=_INK, x=0.01, ha="left")
    with atomic_path(path) as aside:
        figure.savefig(aside, format="png")


def _albedo(axes: Any, health: Health) -> None:
    details = health["energy"].details
    axes.axhline(1.0, color=_INK, linewidth=1.0, linestyle="--")
    axes.text(1.0, 1.005, "white furnace", color=_INK, fontsize=8, va="bottom")
    axes.set(xlim=(0, 90), xlabel="theta_i, degrees", ylabel="directional albedo")
    top = 1.08
    if not details:
        axes.text(45.0, 0.5, "not known from this file", ha="center", color="#777777")
    else:
        curves = details["albedo"]
        alone = len(curves) > len(_CHANNEL)
        for channel, values in curves.items():
            colour = _CHANNEL.get(channel, _INK)
            axes.plot(
                details["theta_i_degrees"],
                values,
                color=colour,
                alpha=0.35 if alone else 1.0,
                marker="o" if len(values) < 15 else None,
                markersize=3,
                label=channel,
            )
            top = max(top, 1.05 * max(values))
        if not alone:
            axes.legend(frameon=False, loc="lower left")
        if "covered" in details:
            axes.set_title("a lower bound: over what was measured", fontsize=9, color="#777777")
    axes.set_ylim(0.0, top)


def _findings(axes: Any, health: Health) -> None:
    axes.set_axis_off()
    line = 1.0
    for finding in health.findings:
        colour = _COLOUR[finding.verdict]
        axes.text(0.0, line, finding.name, va="top", weight="bold", color=_INK)
        axes.text(0.17, line, str(finding.verdict), va="top", color=colour, weight="bold")
        wrapped = textwrap.wrap(finding.sentence, _COLUMNS)
        axes.text(0.29, line, "\n".join(wrapped), va="top", fontsize=9, color=_INK)
        line -= 0.045 * len(wrapped) + 0.045
