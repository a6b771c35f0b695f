"""The sphere image as a sum over known directions, for shading thousands of BRDFs.

A sphere under an illumination asks the same directions of every BRDF. `SphereView` works them
out once: whoever has a BRDF's values there, however they were come by, has the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.render.illumination import Illumination
from brdfit.render.sphere import Queries, Sphere, in_channels, sum_by

__all__ = ["SphereView"]


@dataclass(frozen=True, eq=False)
class SphereView:
    """A sphere, an illumination, and all that the one asks of a BRDF under the other."""

    sphere: Sphere
    illumination: Illumination
    queries: Queries

    @classmethod
    def build(cls, sphere: Sphere, illumination: Illumination) -> SphereView:
        """Return the view.

        Raises `UsageError` for an illumination with a surround: it is no direction.
        """
        if any(illumination.surround):
            raise UsageError(
                f"SphereView: illumination {illumination.name!r} has a surround but a view holds "
                f"directional lights only. Use Sphere.shade, or an illumination without one."
            )
        return cls(sphere, illumination, sphere.directions(illumination))

    def __len__(self) -> int:
        return len(self.queries.pixel)

    def shade(self, values: FloatArray) -> FloatArray:
        """Return the linear image (size, size, channels) of f_r (m, channels) at `queries`."""
        return self.sphere.image(self.disk(values))

    def disk(self, values: FloatArray) -> FloatArray:
        """Return the pixels of the disk (pixels, channels) of f_r (m, channels) at `queries`."""
        values = values[:, None] if values.ndim == 1 else values
        if len(values) != len(self):
            raise UsageError(
                f"SphereView: found values of shape {values.shape} but the view asks for "
                f"{len(self)} directions; give one row for each of view.queries."
            )
        _, _, pixel, light, cosine = self.queries
        amount = in_channels(self.illumination.irradiance, values.shape[1])[light]
        return sum_by(pixel, values * amount * cosine[:, None], len(self.sphere.normal))
