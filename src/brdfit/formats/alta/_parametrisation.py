"""ALTA's coordinates -> directions, for those that determine an isotropic measurement.

Coordinates that leave something open get the usual representative, said in a note:
COS_TH has theta_d = 0; coordinates without phi_d have phi_d = pi/2, where theta_i and
theta_o are equal.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from brdfit.arrays import FloatArray, safe_arccos
from brdfit.geometry import directions_from_half_diff, directions_from_spherical

__all__ = ["OPEN", "PARAMETRISATIONS"]

_Pair = tuple[FloatArray, FloatArray]


def _half(theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray | float) -> _Pair:
    return directions_from_half_diff(theta_h, theta_d, np.asarray(phi_d))


def _cos_th(x: FloatArray) -> _Pair:
    return _half(safe_arccos(x[:, 0]), np.zeros(len(x)), 0.0)


def _cos_th_td(x: FloatArray) -> _Pair:
    return _half(safe_arccos(x[:, 0]), safe_arccos(x[:, 1]), np.pi / 2)


def _rusin_th_td(x: FloatArray) -> _Pair:
    return _half(x[:, 0], x[:, 1], np.pi / 2)


def _rusin_th_td_pd(x: FloatArray) -> _Pair:
    return _half(x[:, 0], x[:, 1], x[:, 2])


def _rusin_th_ph_td_pd(x: FloatArray) -> _Pair:
    # a rotation by phi_h about the normal does not matter to an isotropic material
    return _half(x[:, 0], x[:, 2], x[:, 3])


def _spherical(x: FloatArray) -> _Pair:
    return (
        directions_from_spherical(x[:, 0], x[:, 1]),
        directions_from_spherical(x[:, 2], x[:, 3]),
    )


def _isotropic_dphi(x: FloatArray) -> _Pair:
    zero = np.zeros(len(x))
    wi = directions_from_spherical(x[:, 1], x[:, 2])
    return wi, directions_from_spherical(x[:, 0], zero)


def _projected(theta_l: FloatArray, x: FloatArray, y: FloatArray) -> _Pair:
    wo = directions_from_spherical(np.hypot(x, y), np.arctan2(y, x))
    return directions_from_spherical(theta_l, np.zeros_like(theta_l)), wo


def _tl_tv_projected(x: FloatArray) -> _Pair:
    return _projected(x[:, 0], x[:, 1], x[:, 2])


def _tv_projected(x: FloatArray) -> _Pair:
    return _projected(np.zeros(len(x)), x[:, 0], x[:, 1])


def _cartesian(x: FloatArray) -> _Pair:
    # the view vector comes first
    return x[:, 3:6], x[:, :3]


PARAMETRISATIONS: dict[str, tuple[int, Callable[[FloatArray], _Pair]]] = {
    "COS_TH": (1, _cos_th),
    "COS_TH_TD": (2, _cos_th_td),
    "RUSIN_TH_TD": (2, _rusin_th_td),
    "RUSIN_TH_TD_PD": (3, _rusin_th_td_pd),
    "RUSIN_TH_PH_TD_PD": (4, _rusin_th_ph_td_pd),
    "ISOTROPIC_TV_TL_DPHI": (3, _isotropic_dphi),
    "ISOTROPIC_TL_TV_PROJ_DPHI": (3, _tl_tv_projected),
    "ISOTROPIC_TV_PROJ_DPHI": (2, _tv_projected),
    "SPHERICAL_TL_PL_TV_PV": (4, _spherical),
    "CARTESIAN": (6, _cartesian),
}
"""Name -> (number of coordinates, coordinates (n, dimension) to (wi, wo))."""

OPEN = {
    "COS_TH": "COS_TH leaves theta_d open: taken as 0",
    "COS_TH_TD": "COS_TH_TD leaves phi_d open: taken as pi/2",
    "RUSIN_TH_TD": "RUSIN_TH_TD leaves phi_d open: taken as pi/2",
    "ISOTROPIC_TV_PROJ_DPHI": "ISOTROPIC_TV_PROJ_DPHI has the light at the normal",
}
"""What a parametrisation leaves open, and what was put there."""
