"""Pictures of a BRDF as arrays: shaded spheres, slices, and colour from wavelengths.

    sphere = Sphere(64)
    image = sphere.shade(table, studio())           # linear sRGB (64, 64, channels)

Anything with `evaluate(wi, wo)` can be shaded. `SpherePlan` shades thousands of tables on one
grid; `to_rgb` turns spectral bands into linear sRGB. No files here, and no display: see
`brdfit.tone` for exposure and the sRGB curve.
"""

from __future__ import annotations

from brdfit.render.illumination import (
    ILLUMINATIONS,
    Illumination,
    Rectangle,
    area_studio,
    point,
    studio,
)
from brdfit.render.plan import SpherePlan
from brdfit.render.sphere import Evaluable, Queries, Sphere

__all__ = [
    "ILLUMINATIONS",
    "Evaluable",
    "Illumination",
    "Queries",
    "Rectangle",
    "Sphere",
    "SpherePlan",
    "area_studio",
    "point",
    "studio",
]
