"""How well each correction function is described by those of the other materials.

The poster's test of its correction basis. C_i is the quotient of a material and its description
by the 99 others; it is fitted by the 99 other correction functions (three channels each) at
half of the cells of the universe, and compared at the other half: mean |C_i - description|.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray, IntArray
from brdfit.bench.paper.scene import Scene
from brdfit.bench.real_files import generator
from brdfit.linalg import ridge_with_intercept
from brdfit.reconstruct.correction_basis import CorrectionBasis, MemberGram
from brdfit.reconstruct.members import MemberRows
from brdfit.transform import ErrorMetric

__all__ = ["Expressiveness"]

_CELLS = 20_000
_DAMPINGS = tuple(10.0**exponent for exponent in range(-7, 1))


@dataclass(frozen=True, eq=False)
class Expressiveness:
    """The correction functions of all materials at cells of the universe.

    `values` (n, channels x members) are C, `material` (channels x members,) whose they are.
    """

    values: FloatArray
    material: IntArray
    fitted: BoolArray

    @classmethod
    def of(cls, scene: Scene, metric: ErrorMetric) -> Expressiveness:
        """Build the correction basis of all materials."""
        picked = scene.order[:_CELLS]
        rows = MemberRows(tuple(channel[picked] for channel in scene.at_universe))
        names = tuple(str(material) for material in scene.materials)
        basis = CorrectionBasis.build(MemberGram.of(rows, metric), names)
        rng = generator(scene.settings.seed, "expressiveness")
        return cls(
            values=basis.evaluate(rows),
            material=np.tile(scene.materials, scene.n_channels),
            fitted=rng.random(picked.size) < 0.5,
        )

    def deviation(self, material: int) -> float:
        """Return the mean deviation of a material's functions from their description."""
        own = np.flatnonzero(self.material == material)
        others = np.flatnonzero(self.material != material)
        x, y, inside = self.values[:, others], self.values[:, own], self.fitted
        weights = np.ones(int(inside.sum()))
        intercept, fit = ridge_with_intercept(
            x[inside], y[inside].astype(np.float64), weights, _DAMPINGS
        )
        described = intercept + x[~inside] @ fit.coefficients
        return float(np.abs(y[~inside] - described).mean())
