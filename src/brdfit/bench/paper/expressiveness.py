"""How well each correction function is described by those of the other materials.

The poster's test of its correction basis. C_i is the quotient of a material and its description
by the 99 others; it is fitted by least squares, by the 99 other correction functions of its
channel, at half of some cells of the universe, and compared at the other half: mean
|C_i - description|. Beside it the same by the functions of all three channels together, the
basis that the method uses.
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
# As good as none: it keeps functions that are nearly equal from cancelling one another.
_DAMPING = 1e-6


@dataclass(frozen=True, eq=False)
class Expressiveness:
    """The correction functions of all materials at cells of the universe.

    `values` (n, channels x members) are C, `material` (channels x members,) whose they are.
    """

    values: FloatArray
    material: IntArray
    fitted: BoolArray
    channels: int

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
            channels=scene.n_channels,
        )

    def deviation(self, material: int) -> float:
        """Return the mean deviation of a material's functions, each by those of its channel."""
        size = self.material.size // self.channels
        every = np.arange(self.material.size).reshape(self.channels, size)
        return float(np.mean([self._deviation(material, columns) for columns in every]))

    def deviation_by_all(self, material: int) -> float:
        """Return the mean deviation of a material's functions by those of all channels."""
        return self._deviation(material, np.arange(self.material.size))

    def _deviation(self, material: int, columns: IntArray) -> float:
        is_own = self.material[columns] == material
        # Single precision would lose the small eigenvalues on which a close fit rests.
        x, y = (self.values[:, columns[w]].astype(np.float64) for w in (~is_own, is_own))
        inside = self.fitted
        weights = np.ones(int(inside.sum()))
        intercept, fit = ridge_with_intercept(x[inside], y[inside], weights, (_DAMPING,))
        described = intercept + x[~inside] @ fit.coefficients
        return float(np.abs(y[~inside] - described).mean())
