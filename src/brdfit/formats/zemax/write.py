"""Write Zemax's tabular BSDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.files import atomic_path
from brdfit.formats.xyz import not_negative, refuse_other_channels, xyz_from_linear_rgb
from brdfit.formats.zemax.geometry import directions_from_specular
from brdfit.table import Table

__all__ = ["write_table"]

INCIDENCES = np.arange(0.0, 86.0, 5.0)
"""Degrees."""
RADIALS = np.concatenate(
    [[0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.5], np.arange(10, 40, 5), np.arange(40, 180, 10)]
)
"""Degrees, dense about the specular direction; 175 lies opposite it at incidence 85."""
AZIMUTHS = np.arange(0.0, 361.0, 10.0)
"""Degrees; up to 180 where the material is its own mirror image."""

_BILATERAL = 1e-6


def write_table(table: Table, path: Path) -> None:
    """Write one channel as Monochrome, or linear sRGB as XYZ.

    Values are those of `Table.evaluate`; below the horizon they are 0. Raises `UsageError`
    for other channels, or a table without values.
    """
    refuse_other_channels(table, path, "Zemax's format")
    azimuths, values = _sampled(table)
    values = not_negative(values, path)
    if table.n_channels == 3:
        values, names = xyz_from_linear_rgb(values), [f"Tristimulus{axis}" for axis in "XYZ"]
    else:
        names = ["Monochrome"]
    lines = _header(table, azimuths)
    for channel, name in enumerate(names):
        lines += ["", name, "DataBegin", *_block(azimuths, values[..., channel]), "DataEnd"]
    with atomic_path(path) as aside:
        aside.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _sampled(table: Table) -> tuple[FloatArray, FloatArray]:
    """Return (azimuths in degrees, values (incidences, azimuths, radials, channels))."""
    wi, wo = directions_from_specular(
        np.deg2rad(INCIDENCES)[:, None, None],
        np.deg2rad(AZIMUTHS)[None, :, None],
        np.deg2rad(RADIALS)[None, None, :],
    )
    shape = (*wi.shape[:3], table.n_channels)
    values = table.evaluate(wi.reshape(-1, 3), wo.reshape(-1, 3)).reshape(shape)
    half = len(AZIMUTHS) // 2 + 1
    if np.allclose(values, values[:, ::-1], rtol=_BILATERAL, atol=0.0, equal_nan=True):
        return AZIMUTHS[:half], values[:, :half]
    return AZIMUTHS, values


def _header(table: Table, azimuths: FloatArray) -> list[str]:
    symmetric = len(azimuths) < len(AZIMUTHS)
    return [
        "# written by brdfit",
        "Source\tMeasured",
        f"Symmetry\t{'PlaneSymmetrical' if symmetric else 'Asymmetrical'}",
        f"SpectralContent\t{'XYZ' if table.n_channels == 3 else 'Monochrome'}",
        "ScatterType\tBRDF",
        "SampleRotation\t1",
        "0",
        *_angles("AngleOfIncidence", INCIDENCES),
        *_angles("ScatterAzimuth", azimuths),
        *_angles("ScatterRadial", RADIALS),
    ]


def _angles(name: str, angles: FloatArray) -> list[str]:
    return [f"{name}\t{len(angles)}", "\t".join(f"{angle:g}" for angle in angles)]


def _block(azimuths: FloatArray, values: FloatArray) -> list[str]:
    """Return the lines of one channel: for each incidence TIS, and a row for each azimuth."""
    lines = []
    for at_incidence, incidence in zip(values, INCIDENCES, strict=True):
        lines.append(f"TIS\t{_tis(azimuths, at_incidence, incidence):.6f}")
        lines += ["\t".join(f"{value:.7e}" for value in row) for row in at_incidence]
    return lines


def _tis(azimuths: FloatArray, values: FloatArray, incidence: float) -> float:
    """Return the reflected share of the light: the integral of f_r cos(theta_o).

    The solid angle is sin r dr da about the specular direction; trapezoids in both.
    """
    r, a = np.deg2rad(RADIALS), np.deg2rad(azimuths)
    _, wo = directions_from_specular(np.deg2rad(incidence), a[:, None], r[None, :])
    integrand = values * np.maximum(wo[..., 2], 0.0) * np.sin(r)
    share = np.trapezoid(np.trapezoid(integrand, r, axis=1), a)
    return float(share) * (2.0 if len(azimuths) < len(AZIMUTHS) else 1.0)
