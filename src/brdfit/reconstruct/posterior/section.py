"""What the population alone says of a material, as a function of theta_h and theta_d.

    L(theta_h, theta_d) = ln f_r(theta_h, theta_d, phi_d = pi/2)

the section of direction space in which light and camera are equally high: there every
(theta_h, theta_d) is above the horizon. L is what the kernel of the residual measures distance
in, beside the angles (`kernel.Kernel.lobe`): it tells the flank of a lobe, where a material
changes within a degree, from the plain around it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.grid import Grid

if TYPE_CHECKING:
    from scipy.interpolate import RectBivariateSpline

__all__ = ["SECTION", "Section"]

SECTION = Grid(64, 32, 2)
"""Nodes of L along theta_h and theta_d; the second of two phi_d is pi/2."""
# Where slopes are looked for, along one axis and the other.
_ALONG, _ACROSS = 256, 64


@dataclass(frozen=True, eq=False)
class Section:
    """L (n_theta_h, n_theta_d) at the nodes of `SECTION`."""

    level: FloatArray

    def at(self, theta_h: FloatArray, theta_d: FloatArray) -> FloatArray:
        """Return L (n,), by cubic splines in sqrt(theta_h) and theta_d."""
        return np.asarray(self._spline.ev(np.sqrt(theta_h), theta_d))

    def steepest(self, along: int) -> tuple[FloatArray, FloatArray]:
        """Return (places, slope at each) along sqrt(theta_h) (0) or theta_d (1).

        The slope is the greatest that L has there, wherever on the other axis.
        """
        axes = (np.sqrt(SECTION.theta_h), SECTION.theta_d)
        sizes = (_ALONG, _ACROSS) if along == 0 else (_ACROSS, _ALONG)
        places = [np.linspace(a[0], a[-1], size) for a, size in zip(axes, sizes, strict=True)]
        slope = self._spline(*places, dx=int(along == 0), dy=int(along == 1))
        return places[along], np.abs(slope).max(axis=1 - along)

    @cached_property
    def _spline(self) -> RectBivariateSpline:
        from scipy.interpolate import RectBivariateSpline

        return RectBivariateSpline(np.sqrt(SECTION.theta_h), SECTION.theta_d, self.level, s=0)
