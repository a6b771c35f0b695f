"""The plain analytic material: brdfit's own GGX lobe over a Lambertian base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.export.form import Form, Parameter, Values, colour
from brdfit.models import Ggx, PairAngles

__all__ = ["DIFFUSE", "FORMS", "ROUGHNESS", "GgxMaterial"]

DIFFUSE = Parameter("diffuse", 3, root=True)
ROUGHNESS = Parameter("roughness", low=0.03)
"""Below 0.03 (a lobe of 0.05 degrees) real-time renderers clamp."""


@dataclass(frozen=True)
class GgxMaterial:
    """`brdfit.models.Ggx` in R, G, B: f = diffuse / pi + F D G2 / (4 cos_i cos_o)."""

    diffuse: tuple[float, float, float]
    f0: tuple[float, float, float]
    roughness: float
    """Square root of the GGX alpha."""

    @property
    def model(self) -> Ggx:
        """The model with these parameters."""
        return Ggx(self.diffuse, self.f0, self.roughness**2)

    def at(self, angles: PairAngles) -> FloatArray:
        """Return f_r (n, 3), 1/sr, as if every direction were above the horizon."""
        return self.model.at(angles)

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, 3) in 1/sr at (n, 3); 0 below the horizon."""
        return self.model.evaluate(wi, wo)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters as JSON-able values."""
        return {
            "diffuse": list(self.diffuse),
            "f0": list(self.f0),
            "alpha": self.roughness**2,
            "roughness": self.roughness,
        }


def _make(values: Values) -> GgxMaterial:
    return GgxMaterial(
        diffuse=colour(values["diffuse"]),
        f0=colour(values["f0"]),
        roughness=float(values["roughness"][0]),
    )


def _starts(guess: Ggx) -> Sequence[Values]:
    roughness = np.sqrt(np.asarray(guess.alpha)[:1])
    return [
        {"diffuse": np.asarray(guess.diffuse), "f0": np.asarray(guess.f0)}
        | {"roughness": roughness}
    ]


FORMS = (Form("ggx", (DIFFUSE, Parameter("f0", 3, root=True), ROUGHNESS), _make, _starts),)
"""There is one."""
