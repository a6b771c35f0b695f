"""The picture of a fit can be read: its axes have labels."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from brdfit.report.fit_figure import label_decades


@pytest.mark.parametrize("limits", [(0.31, 0.34), (0.18, 0.7), (0.3, 4.0), (1e-4, 20.0)])
def test_an_axis_of_f_r_has_labels_however_few_decades_it_spans(
    limits: tuple[float, float],
) -> None:
    figure = Figure()
    ax = figure.add_subplot()
    ax.set_yscale("log")
    ax.set_ylim(*limits)
    label_decades(ax)
    figure.canvas.draw()
    shown = [
        label.get_text()
        for label, at in zip(ax.get_yticklabels(), ax.get_yticks(), strict=True)
        if limits[0] <= at <= limits[1]
    ]
    assert len(shown) >= 2
    assert all(shown)
