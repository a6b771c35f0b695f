"""The picture of a fit: spheres, slices with the measurements on them, an image slice.

    point light      area studio      half/difference image slice
    plane-of-incidence slices at three angles of the light, with the measurements

Drawn with the object interface of matplotlib: no window, no global state.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.errors import UsageError
from brdfit.geometry import spherical_from_directions
from brdfit.progress import Progress, silent
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.channels import INK, shown_channels
from brdfit.report.coverage import Coverage
from brdfit.samples import Samples
from brdfit.table import Table
from brdfit.tone import display_image, exposure_scale, srgb_encode

if TYPE_CHECKING:
    from brdfit.albedo import Evaluable
    from brdfit.render import Illumination

__all__ = ["Slice", "draw_fit", "label_decades", "slices_of"]

_SPHERE_SIZE = 128
# Radians between the points of an area light: coarser than for a picture of its own, since
# the time goes with the number of points.
_SPACING = 0.15
# How far a measurement may lie from the plane and the angle of a slice and be drawn on it.
_PLANE = np.radians(5.0)
_ANGLE = np.radians(3.0)
_USUAL = np.radians([15.0, 45.0, 65.0])
_OUTLIER = "#d02020"
# Below so many decades of f_r a label at each of them is next to none.
_FEW_DECADES = 1.5


@dataclass(frozen=True)
class Slice:
    """A plane of incidence: one angle of the light, the samples that lie on it."""

    theta_i: float
    """Polar angle of the light, radians."""
    theta_o: FloatArray
    """(m,) signed polar angle of the other direction, radians; > 0 on the mirror side."""
    rows: IntArray
    """(m,) which samples these are."""


def slices_of(samples: Samples) -> tuple[Slice, ...]:
    """Return the three planes of incidence that the most samples lie on, by angle.

    A sample lies on a slice if its directions are within 5 degrees of one plane through the
    normal, and its light (or, by reciprocity, its detector) within 3 degrees of the angle.
    """
    used = samples.usable.any(axis=1)
    theta_i, signed_o, planar_i = _in_plane(samples.wi, samples.wo)
    theta_o, signed_i, planar_o = _in_plane(samples.wo, samples.wi)
    rows = np.arange(len(samples))
    fixed = np.concatenate([theta_i, theta_o])
    free = np.concatenate([signed_o, signed_i])
    both = np.concatenate([rows, rows])
    keep = np.concatenate([planar_i & used, planar_o & used])
    fixed, free, both = fixed[keep], free[keep], both[keep]
    chosen = []
    for angle in _busiest(fixed):
        near = np.abs(fixed - angle) < _ANGLE
        chosen.append(Slice(float(angle), free[near], both[near]))
    return tuple(chosen)


def _in_plane(fixed: FloatArray, free: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return (theta of fixed, signed theta of free, whether the two share a plane)."""
    theta_fixed, phi_fixed = spherical_from_directions(fixed)
    theta_free, phi_free = spherical_from_directions(free)
    turn = phi_free - phi_fixed
    off = np.minimum(np.sin(theta_fixed), np.sin(theta_free)) * np.abs(np.sin(turn))
    signed = np.where(np.cos(turn) < 0.0, theta_free, -theta_free)
    return theta_fixed, signed, off < np.sin(_PLANE)


def _busiest(theta: FloatArray, count: int = 3) -> list[float]:
    """Return `count` angles at least 12 degrees apart, those with the most samples first."""
    chosen: list[float] = []
    width = np.radians(1.0)
    bins, number = np.unique(np.rint(theta / width).astype(int), return_counts=True)
    low, high = np.radians(8.0), np.radians(80.0)
    for index in np.argsort(-number, kind="stable"):
        angle = float(bins[index] * width)
        if low <= angle <= high and all(abs(angle - other) > np.radians(12.0) for other in chosen):
            chosen.append(angle)
    chosen += [a for a in _USUAL if all(abs(a - other) > np.radians(12.0) for other in chosen)]
    return sorted(chosen[:count])


def draw_fit(
    result: Reconstruction,
    brdf: Evaluable,
    rgb: Table,
    coverage: Coverage | None,
    path: Path,
    progress: Progress = silent,
) -> None:
    """Draw the fit into the PNG `path`.

    `brdf` draws the curves: the result itself, or the table where that says something else;
    `rgb` is the table in R, G, B.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from brdfit.render import area_studio, point

    figure = Figure(figsize=(12.0, 7.6), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    # Places by hand: an automatic layout draws everything once more to find them.
    top = figure.add_gridspec(1, 3, left=0.03, right=0.985, bottom=0.56, top=0.9, wspace=0.14)
    bottom = figure.add_gridspec(
        1, 3, left=0.065, right=0.985, bottom=0.075, top=0.435, wspace=0.24
    )
    for index, light in enumerate((point(), area_studio(_SPACING))):
        progress("drawing", index, 4)
        _draw_sphere(figure.add_subplot(top[index]), rgb, light)
    progress("drawing", 2, 4)
    _draw_image_slice(figure.add_subplot(top[2]), rgb, result.samples)
    progress("drawing", 3, 4)
    for index, one in enumerate(slices_of(result.samples)):
        ax = figure.add_subplot(bottom[index])
        _draw_slice(ax, result, brdf, one)
    figure.legend(*ax.get_legend_handles_labels(), ncols=5, fontsize=8, loc=(0.062, 0.475))
    figure.suptitle(_headline(result, coverage), fontsize=11, x=0.012, ha="left", color=INK)
    figure.savefig(path, format="png")
    progress("drawing", 4, 4)


def _headline(result: Reconstruction, coverage: Coverage | None) -> str:
    used = int(result.samples.usable.any(axis=1).sum())
    share = "" if coverage is None else f", {coverage.share:.0%} of the domain within reach"
    return (
        f"{result.samples.source.name}: {used} samples used{share}; "
        f"{int(result.outliers.sum())} taken for outliers; "
        f"{result.method.name}, {result.outcome.value}"
    )


def _title(ax: Any, text: str) -> None:
    # With y given matplotlib does not lay out all labels once more to find a free height.
    ax.set_title(text, fontsize=10, color=INK, y=1.0)


def _draw_sphere(ax: Any, rgb: Table, light: Illumination) -> None:
    from brdfit.render import Sphere

    ax.set_axis_off()
    _title(ax, f"sphere, {light.name.replace('_', ' ')}")
    sphere = Sphere(_SPHERE_SIZE)
    linear = sphere.shade(rgb, light)
    try:
        scale = exposure_scale(linear, sphere.mask)
    except UsageError:
        ax.text(0.5, 0.5, "nothing to see", ha="center", va="center")
        return
    picture = display_image(linear, scale)
    picture[~sphere.mask] = 1.0
    ax.imshow(picture, interpolation="bilinear")


def _draw_image_slice(ax: Any, rgb: Table, samples: Samples) -> None:
    """Draw the table at phi_d = 90 degrees, and where the samples are."""
    _title(ax, "table at phi_d = 90\N{DEGREE SIGN} (log tones), and samples")
    ax.set_xlabel("theta_h (square-root scale)", fontsize=9)
    ax.set_ylabel("theta_d", fontsize=9)
    half_h, half_d = 0.5 / rgb.grid.n_theta_h, 45.0 / rgb.grid.n_theta_d
    ax.imshow(
        _log_tones(rgb).transpose(1, 0, 2),
        origin="lower",
        # pixels are centred on the nodes
        extent=(-half_h, 1.0 - half_h, -half_d, 90.0 - half_d),
        aspect="auto",
        interpolation="nearest",
    )
    theta_h, theta_d, _ = samples.half_diff
    used = samples.usable.any(axis=1)
    x = np.sqrt(theta_h[used] / (np.pi / 2))
    size = float(np.clip(2000.0 / max(len(x), 1), 0.3, 6.0))
    ax.scatter(x, np.degrees(theta_d[used]), s=size, c="white", edgecolors="black", linewidths=0.2)
    ticks = np.array([0, 5, 15, 30, 60, 90])
    ax.set_xticks(np.sqrt(ticks / 90.0), [f"{tick}\N{DEGREE SIGN}" for tick in ticks], fontsize=8)
    ax.tick_params(labelsize=8)
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(0.0, 90.0)


def _log_tones(rgb: Table) -> FloatArray:
    """Return the plane phi_d = 90 degrees, (n_theta_h, n_theta_d, 3), for the eye.

    Hue as it is, brightness by the logarithm of the largest channel, dark to bright over
    the values that occur: a lobe and a diffuse floor 10^4 apart are both seen.
    """
    middle = rgb.grid.n_phi_d // 2
    plane = rgb.values[:, :, middle, :].astype(np.float64)
    peak = plane.max(axis=2)
    shown = rgb.mask[:, :, middle] & (peak > 0.0)
    picture = np.ones_like(plane)
    if shown.any():
        level = np.log(peak[shown])
        low, high = np.percentile(level, [0.5, 99.5])
        tone = np.clip((level - low) / max(high - low, 1e-9), 0.0, 1.0)
        hue = srgb_encode(plane[shown] / peak[shown][:, None])
        picture[shown] = hue * (0.15 + 0.85 * tone)[:, None]
    return picture


def _draw_slice(ax: Any, result: Reconstruction, brdf: Evaluable, one: Slice) -> None:
    from brdfit.render import incidence_slices

    curve = incidence_slices(brdf, (float(np.degrees(one.theta_i)),), samples=357)
    outlier = result.outliers[one.rows]
    degrees = np.degrees(one.theta_o)
    names = result.samples.channels
    for channel, colour in shown_channels(result.samples.n_channels, result.samples.wavelengths):
        line = curve.values[0, :, channel]
        ax.plot(np.degrees(curve.theta_o), line, color=colour, linewidth=1.2, label=names[channel])
        measured = result.samples.value[one.rows, channel]
        good = result.samples.positive[one.rows, channel] & ~outlier
        ax.plot(degrees[good], measured[good], ".", color=colour, markersize=3.5, alpha=0.8)
        bad = result.samples.positive[one.rows, channel] & outlier
        ax.plot(degrees[bad], measured[bad], "x", color=_OUTLIER, markersize=5, alpha=0.9)
    ax.plot([], [], ".", color=INK, markersize=5, label="measured")
    ax.plot([], [], "x", color=_OUTLIER, markersize=5, label="taken for an outlier")
    ax.axvline(np.degrees(one.theta_i), color="#999999", linewidth=0.6, linestyle=":")
    ax.set_yscale("log")
    label_decades(ax)
    ax.set_xlim(-90.0, 90.0)
    ax.set_xticks(np.arange(-90, 91, 30))
    _title(ax, f"theta_i = {np.degrees(one.theta_i):.0f}\N{DEGREE SIGN}, plane of incidence")
    ax.set_xlabel("theta_o (degrees; mirror side > 0)", fontsize=9)
    ax.set_ylabel("f_r (1/sr)", fontsize=9)
    ax.tick_params(labelsize=8)
    ax.grid(color="#dddddd", linewidth=0.5)


def label_decades(ax: Any) -> None:
    """Put a label at every decade of f_r, and at 2 and 5 times them where these are few."""
    ax.minorticks_off()
    low, high = ax.get_ylim()
    if np.log10(high / low) < _FEW_DECADES:
        from matplotlib.ticker import LogLocator

        ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.yaxis.set_major_formatter("{x:g}")
