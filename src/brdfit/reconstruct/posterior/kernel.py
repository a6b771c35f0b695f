"""The local residual: a smooth Gaussian process that lets a material leave its population.

    x = (stretch sqrt(theta_h / (pi/2)),  theta_d / (pi/2),  r cos 2 phi_d,  r sin 2 phi_d,
         -grazing ln(c + e))
    r = sin theta_h sin theta_d,     c = cos theta_i cos theta_o, smoothly held above zero

    k(x, x') = a^2 (1 + sqrt(3) d) exp(-sqrt(3) d)
    d^2 = |x - x'|^2 / length^2 + lobe^2 (L(x) - L(x'))^2

a Matern kernel of smoothness 3/2 over coordinates that know of reciprocity, and in which phi_d
has no say at the poles. Kernels that are products along (theta_h, theta_d, phi_d) are cheaper
on a grid, but predicted real measurements worse: what changes fast in phi_d changes where
theta_h and theta_d are large, and there only. The fifth coordinate, where a fit wants it
(`grazing` above 0), keeps apart what lies near the horizon: there a BRDF changes faster than
anywhere but in its peak. L(theta_h, theta_d) is what the population alone says of the material
(`section`), where a fit wants it. Where L is steep, as on the flank of a lobe,
samples tell of less around them than where it is flat: no length that is the same everywhere
serves both.

Reference: C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT
Press 2006, section 4.2.1 (Matern).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray
from brdfit.geometry import cos_incident_outgoing
from brdfit.linalg import side_by_side
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.reconstruct.posterior.section import Section

__all__ = ["Angles", "Kernel", "taken"]

Angles = tuple[FloatArray, FloatArray, FloatArray]
"""theta_h, theta_d, phi_d, each (n,), radians."""


# Values of the kernel worked out together: what is next done to them finds them in the cache.
_IN_CACHE = 1 << 17
# e: below this product of cosines it is all one.
_NEAR_HORIZON = 0.04


@dataclass(frozen=True)
class Kernel:
    """Length scale, how much longer theta_h is, and the amplitude a in ln f_r."""

    length: float
    stretch: float
    amplitude: float
    grazing: float = 0.0
    """How much the last decades before the horizon count as distance; 0 for not at all."""
    lobe: float = 0.0
    """Lengths that an e-fold of what the population says counts as; 0 for not at all..."""
    section: Section | None = None
    """...and what it says; None where that is not known."""

    def coordinates(self, angles: Angles) -> FloatArray:
        """Return x / length (n, 4), a column more for each of `grazing` and `lobe`."""
        x = half_diff_features(*(np.asarray(angle, dtype=np.float64) for angle in angles))
        x[:, 0] *= self.stretch
        if self.grazing > 0.0:
            x = np.column_stack([x, -self.grazing * _log_height(angles)])
        x /= self.length
        if self.section is not None and self.lobe > 0.0:
            x = np.column_stack([x, self.lobe * self.section.at(angles[0], angles[1])])
        return np.asarray(x)

    def between(self, one: Angles, other: Angles) -> FloatArray:
        """Return k (n, m), float64."""
        return self._of_coordinates(self.coordinates(one), self.coordinates(other))

    def summed(self, angles: Angles, centres: Angles, alpha: FloatArray) -> FloatArray:
        """Return sum_j k(x, centre_j) alpha_j (n, c), float32, for alpha (m, c).

        3 d^2 = (x, |x|^2, 1) . 3 (-2 z, 1, |z|^2) is one product.
        """
        x, z = self.coordinates(angles), self.coordinates(centres)
        # Distances are differences of squares: from the middle the squares are small.
        middle = z.mean(axis=0) if len(z) else 0.0
        x, z = x - middle, z - middle
        left = np.column_stack([x, (x * x).sum(axis=1), np.ones(len(x))]).astype(np.float32)
        right = 3.0 * np.vstack([-2.0 * z.T, np.ones(len(z)), (z * z).sum(axis=1)])
        right, weights = right.astype(np.float32), (self.amplitude**2 * alpha).astype(np.float32)
        result = np.empty((len(x), weights.shape[1]), dtype=np.float32)
        step = max(1, _IN_CACHE // max(len(z), 1))

        def add_up(number: int) -> None:
            rows = slice(number * step, (number + 1) * step)
            d = left[rows] @ right
            _matern(d, np.empty_like(d))
            np.matmul(d, weights, out=result[rows])

        side_by_side(add_up, -(-len(x) // step))
        return result

    def _of_coordinates(self, x: FloatArray, z: FloatArray) -> FloatArray:
        """Return k from x / length (n, d) and (m, d), in their precision."""
        d = (-2.0 * x) @ z.T
        d += (x * x).sum(axis=1)[:, None]
        d += (z * z).sum(axis=1)
        d *= 3.0
        _matern(d, np.empty_like(d))
        d *= self.amplitude**2
        return np.asarray(d)


def taken(angles: Angles, index: IntArray) -> Angles:
    """Return some of the angles."""
    theta_h, theta_d, phi_d = angles
    return theta_h[index], theta_d[index], phi_d[index]


def _log_height(angles: Angles) -> FloatArray:
    """Return ln(c + e) (n,), c = cos theta_i cos theta_o held above zero, smoothly."""
    cos_i, cos_o = cos_incident_outgoing(*angles)
    c = cos_i * cos_o
    return np.asarray(np.log(_NEAR_HORIZON + 0.5 * (c + np.hypot(c, _NEAR_HORIZON))))


def _matern(d: FloatArray, room: FloatArray) -> None:
    """Put (1 + sqrt(s)) exp(-sqrt(s)) in place of s = 3 d^2; `room` is of its shape."""
    np.maximum(d, 0.0, out=d)
    np.sqrt(d, out=d)
    np.negative(d, out=room)
    np.exp(room, out=room)
    d += 1.0
    d *= room
