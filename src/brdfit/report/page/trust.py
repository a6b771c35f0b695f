"""The map of trust: what was measured, what lies between measurements, what was supplied."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_half_diff
from brdfit.reconstruct.trust import Silent, TrustMap
from brdfit.report.coverage import FAR, NEAR, Coverage, Reach
from brdfit.report.kept_trust import KeptTrust
from brdfit.report.page.pictures import png_uri
from brdfit.report.page.svg import Plot, Scale
from brdfit.report.page.words import percent
from brdfit.samples import Samples

__all__ = ["Trust", "trust_of"]

_SIZE = 60
_PLANES = (
    (0.0, "in the plane of incidence (phi_d = 0)"),
    (90.0, "across it (phi_d = 90°)"),
)
# A sample within so many degrees of phi_d is drawn on the map of that phi_d.
_BESIDE = 15.0
_MOST_DOTS = 1_500
_COLOURS = np.array([[0, 0, 0, 0], [33, 92, 158, 255], [126, 176, 222, 255], [206, 206, 210, 255]])


@dataclass(frozen=True)
class Trust:
    """Shares of the domain, and two maps."""

    classes: tuple[tuple[str, str, str], ...]
    """(style, share in words, what it means), best first."""
    bar: str
    """The shares as one bar, SVG."""
    maps: tuple[tuple[str, str], ...]
    """(caption, SVG)."""


def trust_of(
    samples: Samples, coverage: Coverage, supplier: str, kept: KeptTrust | None = None
) -> Trust:
    """Return where `samples` speak, and where `supplier` does ("the population", ...).

    The classes are the fit's own (`kept`), where it kept them; else distance decides.
    """
    if kept is not None:
        measured, interpolated = kept.map.criteria
        meaning = (
            f"measured: {measured}",
            f"interpolated: {interpolated}",
            f"supplied by {supplier}: all else",
        )
        return _told(samples, kept.shares, meaning, kept.map)
    shares = (
        coverage.share,
        coverage.share_between,
        max(0.0, 1.0 - coverage.share - coverage.share_between),
    )
    meaning = (
        f"measured: a usable measurement lies within {NEAR:g} degrees",
        f"interpolated: the nearest one lies {NEAR:g} to {FAR:g} degrees away",
        f"supplied by {supplier}: no measurement within {FAR:g} degrees",
    )
    return _told(samples, shares, meaning, TrustMap(Reach(samples), Silent()))


def _told(
    samples: Samples,
    shares: tuple[float, float, float],
    meaning: tuple[str, str, str],
    trust: TrustMap,
) -> Trust:
    styles = ("measured", "between", "supplied")
    return Trust(
        classes=tuple(
            (style, percent(share), text)
            for style, share, text in zip(styles, shares, meaning, strict=True)
        ),
        bar=_bar(shares, styles),
        maps=tuple((caption, _map(samples, trust, phi_d)) for phi_d, caption in _PLANES),
    )


def _bar(shares: tuple[float, ...], styles: tuple[str, ...]) -> str:
    root = ET.Element(
        "svg",
        {
            "viewBox": "0 0 600 16",
            "class": "bar",
            "role": "img",
            "preserveAspectRatio": "none",
            "xmlns": "http://www.w3.org/2000/svg",
        },
    )
    said = ", ".join(f"{percent(share)} {s}" for s, share in zip(styles, shares, strict=True))
    ET.SubElement(root, "title").text = f"shares of the domain: {said}"
    left = 0.0
    for style, share in zip(styles, shares, strict=True):
        box = {"x": f"{left:.1f}", "width": f"{600 * share:.1f}", "y": "0", "height": "16"}
        ET.SubElement(root, "rect", {**box, "class": style})
        left += 600 * share
    return ET.tostring(root, encoding="unicode")


def _map(samples: Samples, trust: TrustMap, phi_d: float) -> str:
    root_h = (np.arange(_SIZE) + 0.5) / _SIZE
    theta_h, theta_d = np.meshgrid(root_h**2 * (np.pi / 2), root_h[::-1] * (np.pi / 2))
    plane = np.full(theta_h.shape, np.radians(phi_d))
    directions = directions_from_half_diff(*(a.ravel() for a in (theta_h, theta_d, plane)))
    code = trust.evaluate(*directions).reshape(theta_h.shape)
    ticks = tuple((t, f"{t:g}") for t in (0.0, 5.0, 15.0, 30.0, 60.0, 90.0))
    plot = Plot(
        Scale(0.0, 90.0, ticks, "theta_h, degrees (0 = mirror direction)", "root"),
        Scale.linear(0.0, 90.0, (0, 30, 60, 90), "theta_d, degrees"),
        f"where measurements lie and how far they reach, phi_d = {phi_d:g} degrees",
        size=(360, 260),
    )
    plot.image(png_uri(np.repeat(np.repeat(_COLOURS[code] / 255.0, 3, axis=0), 3, axis=1)))
    x, y = _near_plane(samples, phi_d)
    plot.marks(x, y, "dot", size=1.3)
    return plot.markup()


def _near_plane(samples: Samples, phi_d: float) -> tuple[FloatArray, FloatArray]:
    """Return (theta_h, theta_d) in degrees of the used samples near `phi_d`, degrees."""
    used = samples.usable.any(axis=1)
    theta_h, theta_d, phi = (np.degrees(angle[used]) for angle in samples.half_diff)
    away = np.abs((phi - phi_d + 90.0) % 180.0 - 90.0)
    # at a pole phi_d means nothing: such a sample lies in every plane
    near = (away <= _BESIDE) | (theta_h < 1.0) | (theta_d < 1.0)
    step = max(1, -(-int(near.sum()) // _MOST_DOTS))
    return theta_h[near][::step], theta_d[near][::step]
