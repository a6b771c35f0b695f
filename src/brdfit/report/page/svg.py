"""Plots as SVG, written element by element: small, sharp in print, the same bytes every time.

Colours are classes, so that a style sheet makes them dark or light. Every text goes through
the XML writer, which escapes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.report.page.words import number

__all__ = ["Plot", "Scale", "decades"]

_LEFT, _RIGHT, _TOP, _BOTTOM = 52.0, 8.0, 8.0, 40.0
_SVG = "http://www.w3.org/2000/svg"


def decades(values: FloatArray, most: float = 6.0) -> tuple[float, float]:
    """Return (low, high) of a logarithmic axis that shows the positive `values`."""
    positive = values[np.isfinite(values) & (values > 0.0)]
    if positive.size == 0:
        return 0.1, 10.0
    high = float(positive.max()) * 1.3
    return max(float(positive.min()) / 1.3, high / 10.0**most), high


@dataclass(frozen=True)
class Scale:
    """One axis: from values to places."""

    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    """(value, label)."""
    label: str
    kind: str = "linear"
    """"linear", "log" or "root" (the square-root warp of theta_h)."""

    @classmethod
    def linear(cls, low: float, high: float, ticks: Sequence[float], label: str) -> Scale:
        """Return an even axis with these ticks."""
        return cls(low, high, tuple((t, f"{t:g}") for t in ticks), label)

    @classmethod
    def log(cls, low: float, high: float, label: str) -> Scale:
        """Return a logarithmic axis with a tick a decade, or more where there are few."""
        first, last = int(np.floor(np.log10(low))), int(np.ceil(np.log10(high)))
        steps = (1,) if last - first > 2 else (1, 2, 5)
        values = [step * 10.0**power for power in range(first, last + 1) for step in steps]
        shown = tuple((v, number(v, 1)) for v in values if low <= v <= high)
        return cls(low, high, shown, label, "log")

    def place(self, values: FloatArray) -> FloatArray:
        """Return places in [0, 1], clipped."""
        low, high, at = (self._warped(np.asarray(v)) for v in (self.low, self.high, values))
        return np.clip((at - low) / (high - low), 0.0, 1.0)

    def _warped(self, values: FloatArray) -> FloatArray:
        if self.kind == "log":
            return np.log(np.maximum(values, 1e-300))
        return np.sqrt(values) if self.kind == "root" else values


class Plot:
    """One plot: axes first, then what is drawn on them, in order."""

    def __init__(self, x: Scale, y: Scale, alt: str, size: tuple[int, int] = (360, 230)) -> None:
        self._x, self._y = x, y
        self._width, self._height = size
        self.root = ET.Element(
            "svg",
            {"xmlns": _SVG, "viewBox": f"0 0 {size[0]} {size[1]}", "role": "img", "class": "plot"},
        )
        ET.SubElement(self.root, "title").text = alt
        self._axes()

    def markup(self) -> str:
        """Return the SVG element."""
        return ET.tostring(self.root, encoding="unicode")

    def line(self, x: FloatArray, y: FloatArray, style: str) -> None:
        """Draw a curve; gaps where it is not finite, or not positive on a log axis."""
        shown = np.isfinite(y) & ((y > 0.0) if self._y.kind == "log" else True)
        for part in _runs(shown):
            self._path(self._points(x[part], y[part]), style, close=False)

    def band(self, x: FloatArray, low: FloatArray, high: FloatArray, style: str) -> None:
        """Fill between two curves."""
        for part in _runs(np.isfinite(low) & np.isfinite(high) & (high > 0.0)):
            there, back = self._points(x[part], high[part]), self._points(x[part], low[part])
            self._path([*there, *reversed(back)], style, close=True)

    def marks(
        self, x: FloatArray, y: FloatArray, style: str, *, cross: bool = False, size: float = 2.0
    ) -> None:
        """Draw a dot, or a cross, at each point."""
        for px, py in self._points(x, y):
            if cross:
                arms = f"M{px - 3:.1f} {py - 3:.1f}l6 6m0-6l-6 6"
                ET.SubElement(self.root, "path", {"d": arms, "class": style})
            else:
                place = {"cx": f"{px:.1f}", "cy": f"{py:.1f}", "r": f"{size:g}", "class": style}
                ET.SubElement(self.root, "circle", place)

    def across(self, y: float, text: str) -> None:
        """Draw a dashed line at `y`, and say what it is."""
        (x0, py), (x1, _) = self._points(np.array([self._x.low, self._x.high]), np.full(2, y))
        line = {"x1": f"{x0:.1f}", "x2": f"{x1:.1f}", "y1": f"{py:.1f}", "y2": f"{py:.1f}"}
        ET.SubElement(self.root, "line", {**line, "class": "guide"})
        # below the line where there is no room above
        at = py - 4 if py > _TOP + 12 else py + 11
        self._text(x1 - 3, at, text, "end", "note")

    def image(self, uri: str) -> None:
        """Fill the plot with a picture, its top row at the top."""
        box = {
            "x": f"{_LEFT:g}",
            "y": f"{_TOP:g}",
            "width": f"{self._width - _LEFT - _RIGHT:g}",
            "height": f"{self._height - _TOP - _BOTTOM:g}",
            "preserveAspectRatio": "none",
            "href": uri,
            "class": "map",
        }
        ET.SubElement(self.root, "image", box)

    def _axes(self) -> None:
        bottom, right = self._height - _BOTTOM, self._width - _RIGHT
        for value, label in self._x.ticks:
            px = _LEFT + float(self._x.place(np.asarray(value))) * (right - _LEFT)
            self._rule(px, px, _TOP, bottom)
            self._text(px, bottom + 13, label, "middle", "tick")
        for value, label in self._y.ticks:
            py = bottom - float(self._y.place(np.asarray(value))) * (bottom - _TOP)
            self._rule(_LEFT, right, py, py)
            self._text(_LEFT - 4, py + 3.5, label, "end", "tick")
        self._text((_LEFT + right) / 2, self._height - 8, self._x.label, "middle", "label")
        side = self._text(0, 0, self._y.label, "middle", "label")
        side.set("transform", f"translate(12 {(_TOP + bottom) / 2:g}) rotate(-90)")

    def _rule(self, x1: float, x2: float, y1: float, y2: float) -> None:
        ends = {"x1": x1, "x2": x2, "y1": y1, "y2": y2}
        shown = {name: f"{value:.1f}" for name, value in ends.items()}
        ET.SubElement(self.root, "line", {**shown, "class": "grid"})

    def _text(self, x: float, y: float, text: str, anchor: str, style: str) -> ET.Element:
        place = {"x": f"{x:.1f}", "y": f"{y:.1f}", "text-anchor": anchor, "class": style}
        element = ET.SubElement(self.root, "text", place)
        element.text = text
        return element

    def _points(self, x: FloatArray, y: FloatArray) -> list[tuple[float, float]]:
        bottom, right = self._height - _BOTTOM, self._width - _RIGHT
        px = _LEFT + self._x.place(x) * (right - _LEFT)
        py = bottom - self._y.place(y) * (bottom - _TOP)
        return list(zip(px.tolist(), py.tolist(), strict=True))

    def _path(self, points: list[tuple[float, float]], style: str, *, close: bool) -> None:
        d = "M" + "L".join(f"{px:.1f} {py:.1f}" for px, py in points) + ("Z" if close else "")
        ET.SubElement(self.root, "path", {"d": d, "class": style})


def _runs(shown: BoolArray) -> list[slice]:
    """Return the stretches of True, each at least two long."""
    padded = np.concatenate([[False], shown, [False]]).astype(np.int8)
    starts, ends = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    return [slice(a, b) for a, b in zip(starts.tolist(), ends.tolist(), strict=True) if b - a > 1]
