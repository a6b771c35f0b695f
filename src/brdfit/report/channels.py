"""Channels in words; which of many a plot shows, and in which colours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from brdfit.arrays import FloatArray

__all__ = ["INK", "Shown", "channels_in_words", "shown_channels"]

INK = "#222222"
_RGB = ("#c03030", "#208030", "#2050c0")
_GREYS = (INK, "#777777", "#aaaaaa")
_NEAR_NM = (620.0, 540.0, 460.0)


class Shown(NamedTuple):
    """A channel that is drawn."""

    channel: int
    """Its index."""
    colour: str
    """#rrggbb"""


def shown_channels(n_channels: int, wavelengths: FloatArray | None) -> list[Shown]:
    """Return at most three channels and the colours to draw them in.

    Of bands those nearest to 620, 540 and 460 nm; otherwise the first three.
    """
    if n_channels == 1:
        return [Shown(0, INK)]
    if wavelengths is None:
        colours = _RGB if n_channels == 3 else _GREYS
        return [Shown(index, colour) for index, colour in enumerate(colours[:n_channels])]
    near = {
        int(np.argmin(np.abs(wavelengths - wavelength))): colour
        for wavelength, colour in zip(_NEAR_NM, _RGB, strict=True)
    }
    return [Shown(index, colour) for index, colour in near.items()]


def channels_in_words(names: tuple[str, ...]) -> str:
    """Return "3 channels (R, G, B)"; of many the first and the last."""
    if len(names) == 1:
        return f"1 channel ({names[0]})"
    if len(names) <= 4:
        return f"{len(names)} channels ({', '.join(names)})"
    return f"{len(names)} channels ({names[0]} ... {names[-1]})"
