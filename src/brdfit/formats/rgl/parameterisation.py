"""The adaptive parameterisation: which directions a node stands for, and f_r in between.

A microsurface normal wm = (theta_m, phi_m), phi_m counted from the azimuth of wi, is the
point of the unit square

    x = sqrt(2 theta_m / pi),   y = (phi_m + pi) / (2 pi)

and the warp of the density of normals visible from wi takes the node lattice (s_x, s_y)
there; wo is wi mirrored at wm. What is stored at a node is

    M = f_r(wi, wo) cos(theta_o) 4 sigma(wi) / D(wm)

so that f_r = M D / (4 sigma cos(theta_o)): the reference evaluator of the authors leaves
the cosine in, here it is divided out, once, and nowhere else.

Reference: Dupuy and Jakob 2018 (see `brdfit.formats.rgl.warp`), sections 3 and 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brdfit.arrays import FloatArray, IntArray, dot, normalize
from brdfit.formats.rgl.measurement import Measurement
from brdfit.formats.rgl.warp import Warp, bilinear, split
from brdfit.geometry import directions_from_spherical, spherical_from_directions

__all__ = ["Parameterisation"]


@dataclass(frozen=True)
class Parameterisation:
    """A measurement with the warp of its normals; build it with `Parameterisation.of`."""

    measurement: Measurement
    warp: Warp

    @classmethod
    def of(cls, measurement: Measurement) -> Parameterisation:
        """Integrate the densities of visible normals, once."""
        return cls(measurement, Warp.of(measurement.vndf))

    def nodes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return (wi, wo, f_r cos(theta_o)) of all nodes, (t, r, k, 3 | 3 | channels).

        wi is at azimuth 0. Some wo are below the horizon, where f_r is not defined.
        """
        m = self.measurement
        t, r, k, _ = m.values.shape
        lattice_x, lattice_y = np.linspace(0.0, 1.0, k), np.linspace(0.0, 1.0, r)
        points = np.stack([self.warp.forward(index, lattice_x, lattice_y) for index in range(t)])
        x, y = points[..., 0], points[..., 1]
        wm = directions_from_spherical(x * x * (np.pi / 2), (2.0 * y - 1.0) * np.pi)
        wi = directions_from_spherical(m.theta_i, np.zeros(t))[:, None, None, :]
        wi = np.broadcast_to(wi, wm.shape)
        wo = normalize(2.0 * dot(wi, wm)[..., None] * wm - wi)
        scale = self._scale(x, y, m.theta_i[:, None, None], np.zeros((t, 1, 1)))
        return wi, wo, m.values * scale[..., None]

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels), 1/sr, at direction pairs (n, 3) above the horizon.

        Bilinear between the nodes, linear between the incidence angles, which are not
        exchanged with the outgoing ones: reciprocity holds as far as it was measured.
        """
        theta_i, phi_i = spherical_from_directions(wi)
        theta_m, phi_m = spherical_from_directions(normalize(wi + wo))
        x = np.sqrt(theta_m * (2.0 / np.pi))
        y = (phi_m - phi_i) / (2.0 * np.pi) + 0.5
        y -= np.floor(y)
        index, fraction = self._incidence(theta_i)
        s_x, s_y = self.warp.inverse(index, fraction, x, y)
        stored = self._between_nodes(index, fraction, s_x, s_y)
        return stored * (self._scale(x, y, theta_i, phi_i) / wo[..., 2])[:, None]

    def _incidence(self, theta_i: FloatArray) -> tuple[IntArray, FloatArray]:
        angles = self.measurement.theta_i
        index = np.clip(np.searchsorted(angles, theta_i, side="right") - 1, 0, angles.size - 2)
        fraction = (theta_i - angles[index]) / (angles[index + 1] - angles[index])
        return index, np.clip(fraction, 0.0, 1.0)

    def _between_nodes(
        self, index: IntArray, fraction: FloatArray, s_x: FloatArray, s_y: FloatArray
    ) -> FloatArray:
        _, r, k, channels = self.measurement.values.shape
        nodes = self.measurement.values.reshape(-1, channels)
        i, u = split(s_x, k)
        j, v = split(s_y, r)
        result = np.zeros((len(s_x), channels))
        for at, in_t in ((index, 1.0 - fraction), (index + 1, fraction)):
            for row, in_y in ((j, 1.0 - v), (j + 1, v)):
                for column, in_x in ((i, 1.0 - u), (i + 1, u)):
                    node = (at * r + row) * k + column
                    result += (in_t * in_y * in_x)[:, None] * nodes.take(node, axis=0)
        return result

    def _scale(
        self, x: FloatArray, y: FloatArray, theta_i: FloatArray, phi_i: FloatArray
    ) -> FloatArray:
        """D(wm) / (4 sigma(wi)), or 1 where it was not divided out."""
        m = self.measurement
        if not m.jacobian:
            return np.ones(x.shape)
        area = bilinear(m.sigma, np.sqrt(theta_i * (2.0 / np.pi)), phi_i / (2.0 * np.pi) + 0.5)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(bilinear(m.ndf, x, y) / (4.0 * area))
