"""Slices of a BRDF as arrays for plots.

    plane of incidence    f_r against theta_o for several theta_i; peaks stand at theta_o = theta_i
    half/difference       f_r over theta_h x theta_d at phi_d = 90 degrees, where both
                          directions are above the horizon everywhere: the "image slice" in
                          which the specular peak is the left edge, grazing retro-reflection
                          and Fresnel effects the top

Reference for the image slice: B. Burley, "Physically-Based Shading at Disney", SIGGRAPH 2012
course notes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray
from brdfit.geometry import directions_from_half_diff, directions_from_spherical

__all__ = ["IncidenceSlices", "half_difference_image", "incidence_slices"]

_THETA_I = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)
# A slice ends a degree before grazing: at the horizon no BRDF is defined.
_LAST = 89.0


@dataclass(frozen=True, eq=False)
class IncidenceSlices:
    """f_r in the plane of incidence.

    | name      | shape            | unit and range                                         |
    |-----------|------------------|--------------------------------------------------------|
    | `theta_i` | (k,)             | radians, [0, pi/2)                                     |
    | `theta_o` | (m,)             | radians; positive on the side of the mirror direction  |
    | `values`  | (k, m, channels) | f_r, 1/sr                                              |
    """

    theta_i: FloatArray
    theta_o: FloatArray
    values: FloatArray


def incidence_slices(
    brdf: Evaluable, theta_i: tuple[float, ...] = _THETA_I, samples: int = 179
) -> IncidenceSlices:
    """Return f_r at angles of incidence `theta_i` (degrees) against theta_o in -89..89 degrees."""
    incident = np.deg2rad(np.asarray(theta_i, dtype=np.float64))
    outgoing = np.deg2rad(np.linspace(-_LAST, _LAST, samples))
    # The light leans toward +x; a positive theta_o leans toward -x, where the mirror is.
    wi = directions_from_spherical(np.repeat(incident, samples), np.zeros(1))
    wo = directions_from_spherical(np.tile(outgoing, incident.size), np.full(1, np.pi))
    value = brdf.evaluate(wi, wo)
    return IncidenceSlices(incident, outgoing, value.reshape(incident.size, samples, -1))


def half_difference_image(brdf: Evaluable, size: int = 90) -> FloatArray:
    """Return f_r (size, size, channels) over theta_d (rows, row 0 = grazing) and theta_h.

    Middle of pixels, both angles evenly in [0, pi/2], phi_d = 90 degrees. Reads as an
    image: the lower left corner is the specular peak at normal incidence.
    """
    middle = (np.arange(size) + 0.5) / size * (np.pi / 2)
    theta_h, theta_d = np.meshgrid(middle, middle[::-1])
    wi, wo = directions_from_half_diff(theta_h.ravel(), theta_d.ravel(), np.full(1, np.pi / 2))
    return np.asarray(brdf.evaluate(wi, wo).reshape(size, size, -1))
