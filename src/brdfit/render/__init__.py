"""Pictures of a BRDF as arrays: shaded spheres, slices, and colour from wavelengths.

    sphere = Sphere(64)
    brdf = ForDisplay.of(table, table.wavelengths, table.channels)
    image = sphere.shade(brdf, studio())           # linear sRGB (64, 64, 3), or one grey channel

Anything with `evaluate(wi, wo)` can be shaded. `SphereView` shades thousands of them from
their values at the same directions; `to_rgb` turns spectral bands into linear sRGB. No files
here, and no display: see `brdfit.tone` for exposure and the sRGB curve.
"""

from __future__ import annotations

from brdfit.albedo import Evaluable
from brdfit.render.ball import MaterialBall
from brdfit.render.environment import Environment
from brdfit.render.illumination import (
    ILLUMINATIONS,
    Illumination,
    Rectangle,
    area_studio,
    point,
    studio,
)
from brdfit.render.panorama import panorama_lights
from brdfit.render.slices import IncidenceSlices, half_difference_image, incidence_slices
from brdfit.render.spectral import (
    ForDisplay,
    display_matrix,
    rgb_matrix,
    shows_colour,
    to_rgb,
)
from brdfit.render.sphere import Queries, Sphere
from brdfit.render.under_environment import shade_under
from brdfit.render.view import SphereView

__all__ = [
    "ILLUMINATIONS",
    "Environment",
    "Evaluable",
    "ForDisplay",
    "Illumination",
    "IncidenceSlices",
    "MaterialBall",
    "Queries",
    "Rectangle",
    "Sphere",
    "SphereView",
    "area_studio",
    "display_matrix",
    "half_difference_image",
    "incidence_slices",
    "panorama_lights",
    "point",
    "rgb_matrix",
    "shade_under",
    "shows_colour",
    "studio",
    "to_rgb",
]
