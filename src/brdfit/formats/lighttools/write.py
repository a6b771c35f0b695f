"""Write LightTools' tabular BSDF.

The keywords are those that the reader of libbsdf takes. The light stands at POI 0, azimuth 90
degrees, so that the specular direction is at ScatterAzimuth 270 and ScatterRadial = AOI.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.files import atomic_path
from brdfit.formats.xyz import not_negative, refuse_other_channels, xyz_from_linear_rgb
from brdfit.geometry import directions_from_spherical
from brdfit.table import Table

__all__ = ["write_table"]

INCIDENCES = np.arange(0.0, 86.0, 5.0)
"""Degrees."""
RADIALS = np.arange(0.0, 89.0, 1.0)
"""Degrees; every specular direction is among them."""
_NEAR = np.array([0.5, 1.0, 2.0, 3.0])
AZIMUTHS = np.union1d(np.arange(0.0, 361.0, 5.0), [270.0 - _NEAR, 270.0 + _NEAR])
"""Degrees, dense about the specular direction."""

_TRISTIMULUS = ("TrisX", "TrisY", "TrisZ")
# What stands for one channel without a wavelength: the middle of the visible.
_WAVELENGTH = 550.0


def write_table(table: Table, path: Path) -> None:
    """Write one channel as Monochrome, or linear sRGB as XYZ.

    Values are those of `Table.evaluate`. Raises `UsageError` for other channels, or a table
    without values.
    """
    refuse_other_channels(table, path, "LightTools' format")
    values = not_negative(_sampled(table), path)
    colour = table.n_channels == 3
    if colour:
        values = xyz_from_linear_rgb(values)
    wave = _WAVELENGTH if table.wavelengths is None else float(table.wavelengths[0])
    lines = [
        "# written by brdfit",
        "Symmetry Asymmetric",
        f"SpectralContent {'XYZ' if colour else 'Monochrome'}",
        *_angles("ScatterAzimuth", AZIMUTHS),
        *_angles("ScatterRadial", RADIALS),
        "DataBegin",
    ]
    for incidence, at_incidence in zip(INCIDENCES, values, strict=True):
        for channel in range(table.n_channels):
            lines += [f"AOI {incidence:g}", "POI 0", "Side Front", f"Wavelength {wave:g}"]
            lines += ["ScatterType BRDF"]
            lines += [f"TristimulusValue {_TRISTIMULUS[channel]}"] if colour else []
            lines += _block(at_incidence[..., channel])
    with atomic_path(path) as aside:
        aside.write_text("\n".join([*lines, "DataEnd"]) + "\n", encoding="utf-8", newline="\n")


def _sampled(table: Table) -> FloatArray:
    """Return values (incidences, azimuths, radials, channels)."""
    wi = directions_from_spherical(np.deg2rad(INCIDENCES), np.array(np.pi / 2))
    radial, azimuth = np.deg2rad(RADIALS)[None, :], np.deg2rad(AZIMUTHS)[:, None]
    wo = directions_from_spherical(radial, azimuth).reshape(-1, 3)
    values = [table.evaluate(np.broadcast_to(w, wo.shape), wo) for w in wi]
    return np.stack(values).reshape(len(wi), AZIMUTHS.size, RADIALS.size, table.n_channels)


def _angles(name: str, angles: FloatArray) -> list[str]:
    return [f"{name} {len(angles)}", " ".join(f"{angle:g}" for angle in angles)]


def _block(values: FloatArray) -> list[str]:
    """Return TIS, the integral of f_r cos(theta_o) by trapezoids, and a row for each azimuth."""
    radial = np.deg2rad(RADIALS)
    ring = np.trapezoid(values * np.cos(radial) * np.sin(radial), radial, axis=1)
    tis = float(np.trapezoid(ring, np.deg2rad(AZIMUTHS)))
    return [f"TIS {tis:.6f}", *(" ".join(f"{value:.7e}" for value in row) for row in values)]
