"""Many spheres on one picture, each with its name below it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.files import atomic_path

__all__ = ["write_contact_sheet"]

_DPI = 100
_GAP, _LABEL = 8, 22
# Letters of the label font are about this many pixels wide.
_LETTER = 6.5


def write_contact_sheet(
    pictures: Sequence[tuple[str, FloatArray]], path: Path, columns: int | None = None
) -> None:
    """Write display pictures (size, size, 3) of one size with their labels as PNG.

    `columns` pictures in a row; left out, as many as make the sheet about square.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if not pictures:
        raise UsageError("contact sheet: there are no pictures to put on it.")
    across = min(columns or math.ceil(math.sqrt(len(pictures))), len(pictures))
    down = math.ceil(len(pictures) / across)
    size = pictures[0][1].shape[0]
    width, height = _GAP + across * (size + _GAP), _GAP + down * (size + _LABEL + _GAP)
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, facecolor="black")
    FigureCanvasAgg(figure)
    for index, (label, picture) in enumerate(pictures):
        row, column = divmod(index, across)
        left, top = _GAP + column * (size + _GAP), _GAP + row * (size + _LABEL + _GAP)
        figure.figimage(picture.clip(0.0, 1.0), xo=left, yo=height - top - size, origin="upper")
        figure.text(
            (left + size / 2) / width,
            1.0 - (top + size + _LABEL / 2) / height,
            _shortened(label, int(size / _LETTER)),
            color="white",
            fontsize=7.5,
            ha="center",
            va="center",
            parse_math=False,
        )
    with atomic_path(path) as aside:
        figure.savefig(aside, format="png", facecolor="black")


def _shortened(label: str, letters: int) -> str:
    """Keep the two ends of a label that is too long: names of a series differ at the end."""
    if len(label) <= letters:
        return label
    half = max(1, (letters - 1) // 2)
    return f"{label[:half]}…{label[-half:]}"
