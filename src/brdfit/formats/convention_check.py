"""Find data that contradict the convention they were read with.

Four mistakes leave a mark that can be told from a material:

- *angles in degrees read as radians* scatter the directions over the whole sphere, and
  *radians read as degrees* crowd all of them around the normal (pi becomes 3.1 degrees);
- *an azimuth off by pi* (specular at phi_o = phi_i instead of phi_i + pi) puts the peak where
  the light comes from;
- *a cosine too many or too few* breaks Helmholtz reciprocity by just that cosine.

Light and detector exchanged cannot be seen: a BRDF is reciprocal, so the exchanged data are
as good. Only where the values were also divided by the cosine of the wrong one does
reciprocity tell. A material that sends more light back than forward (plaster, felt, tape)
looks much like a turned azimuth, so a weak preference is not reported.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from brdfit.arrays import BoolArray, FloatArray
from brdfit.errors import ConventionWarning
from brdfit.geometry import half_diff_from_directions, spherical_from_directions
from brdfit.samples import Flag, Samples

__all__ = ["Contradiction", "check_conventions", "warn_about_conventions"]

_FEWEST = 5
_BELOW_SHARE = 1.0 / 3.0
_CROWDED = np.deg2rad(3.2)  # pi read as degrees is 3.14 degrees

# A sample is near the mirror direction if its half angle is below _NEAR while the half angle
# with the azimuth turned is beyond _AWAY; near the retro direction the other way round.
_NEAR = np.deg2rad(15.0)
_AWAY = np.deg2rad(18.0)
_FEWEST_NEAR = 3
_MANY_NEAR = 15
# ln of the ratio of the brightest. Back-scattering materials of CUReT reach 0.6.
_BRIGHTER = 1.0
_BRIGHTER_FEW = 3.5
# Rank correlation of ln f with either half angle, for materials without a peak.
_FALLS = -0.7
_FLAT = 0.3
_FEWEST_RANKED = 100

_SAME_PAIR = np.deg2rad(1.5)
_FEWEST_PAIRS = 10
_UNEQUAL = 0.25  # ln(cos theta_o / cos theta_i): pairs that can tell
_ENOUGH = 20_000  # samples whose partner is looked for
_EXPONENT_OFF = 0.3
_EXPONENT_SPREAD = 0.4


@dataclass(frozen=True)
class Contradiction:
    """One finding: a name for programs, a message for people."""

    kind: str
    message: str


def warn_about_conventions(samples: Samples) -> None:
    """Give a `ConventionWarning` for each contradiction."""
    for found in check_conventions(samples):
        warnings.warn(f"{samples.source.name}: {found.message}", ConventionWarning, stacklevel=4)


def check_conventions(samples: Samples) -> tuple[Contradiction, ...]:
    """Return what contradicts the convention; empty where nothing does or nothing can tell.

    Where the angles cannot be right the values are not looked at.
    """
    angles = _check_angles(samples)
    if angles:
        return angles
    wi, wo, log_value = _bright(samples)
    if len(log_value) < _FEWEST:
        return ()
    # a cosine too many also shifts the balance of forward and back
    return _check_cosine(wi, wo, log_value) or _check_azimuth(wi, wo, log_value)


def _check_angles(samples: Samples) -> tuple[Contradiction, ...]:
    put_aside = int(Flag.UNREADABLE | Flag.REJECTED)
    finite = np.isfinite(samples.wi).all(axis=1) & np.isfinite(samples.wo).all(axis=1)
    looked_at = finite & ((samples.bits & put_aside) == 0)
    n = int(np.count_nonzero(looked_at))
    if n < _FEWEST:
        return ()
    below = np.count_nonzero(samples.bits[looked_at] & int(Flag.BELOW_HORIZON)) / n
    if below > _BELOW_SHARE:
        message = (
            f"{below:.0%} of the directions are below the horizon. The angles are probably in "
            f"degrees but were read as radians, or the normal is not +z; declare angles."
        )
        return (Contradiction("below horizon", message),)
    cosine = np.minimum(samples.wi[finite, 2], samples.wo[finite, 2])
    if cosine.min() > np.cos(_CROWDED):
        message = (
            "all directions are within 3.2 degrees of the normal. The angles are probably in "
            "radians but were read as degrees; declare angles."
        )
        return (Contradiction("crowded", message),)
    return ()


def _bright(samples: Samples) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return (wi, wo, ln of the middle positive channel) of the samples that have one."""
    positive = samples.positive
    some = positive.any(axis=1)
    value = np.where(positive[some], samples.value[some], np.nan)
    return samples.wi[some], samples.wo[some], np.log(np.nanmedian(value, axis=1))


def _check_azimuth(
    wi: FloatArray, wo: FloatArray, log_value: FloatArray
) -> tuple[Contradiction, ...]:
    declared, _, _ = half_diff_from_directions(wi, wo)
    turned, _, _ = half_diff_from_directions(wi, wo * np.array([-1.0, -1.0, 1.0]))
    mirror = log_value[(declared < _NEAR) & (turned > _AWAY)]
    retro = log_value[(turned < _NEAR) & (declared > _AWAY)]
    fewest = min(len(mirror), len(retro))
    if fewest >= _FEWEST_NEAR:
        # the second brightest: one wrong measurement must not decide
        brighter = float(np.sort(retro)[-2] - np.sort(mirror)[-2])
        if brighter > (_BRIGHTER if fewest >= _MANY_NEAR else _BRIGHTER_FEW):
            return (_azimuth_turned(f"brighter by a factor of {np.exp(brighter):.3g}"),)
    far = np.maximum(declared, turned) > _AWAY
    if np.count_nonzero(far) < _FEWEST_RANKED:
        return ()
    with_declared = _rank_correlation(declared[far], log_value[far])
    with_turned = _rank_correlation(turned[far], log_value[far])
    if with_turned < _FALLS and abs(with_declared) < _FLAT:
        return (_azimuth_turned("toward which the values rise, and do not toward the mirror"),)
    return ()


def _azimuth_turned(how: str) -> Contradiction:
    message = (
        f"the specular peak lies on the side of the light (phi_o = phi_i), {how}, but was "
        f"expected around the mirror direction (phi_o = phi_i + 180 degrees). The azimuth of "
        f"one side is probably counted from the opposite direction; add 180 degrees to it, "
        f"unless the material really is retroreflective."
    )
    return Contradiction("azimuth", message)


def _check_cosine(
    wi: FloatArray, wo: FloatArray, log_value: FloatArray
) -> tuple[Contradiction, ...]:
    """Measure k in value = f_r cos(theta_o)^k from pairs with light and detector exchanged.

    For such a pair f_r is equal, so ln(value_1 / value_2) = k ln(cos theta_o / cos theta_i).
    """
    exponents = _exponents(wi, wo, log_value)
    if len(exponents) < _FEWEST_PAIRS:
        return ()
    low, middle, high = np.percentile(exponents, [25.0, 50.0, 75.0])
    if high - low > _EXPONENT_SPREAD:
        return ()
    for k, meaning in _MEANING.items():
        if abs(middle - k) < _EXPONENT_OFF:
            message = (
                f"exchanging light and detector changes the values as cos(theta_o)^{middle:.2f} "
                f"({len(exponents)} pairs), where f_r must not change: {meaning}"
            )
            return (Contradiction("cosine", message),)
    return ()


_MEANING = {
    1: "the values still hold the cosine of the detector; declare cosine_weighted = true.",
    -1: (
        "the values hold the cosine of the light, or were divided by that of the detector "
        "without need; check cosine_weighted and which side is the light."
    ),
    -2: (
        "light and detector are probably exchanged, so that the values were divided by the "
        "wrong cosine; declare light as the other side."
    ),
}


def _exponents(wi: FloatArray, wo: FloatArray, log_value: FloatArray) -> FloatArray:
    from scipy.spatial import cKDTree

    theta_i, phi_i = spherical_from_directions(wi)
    theta_o, phi_o = spherical_from_directions(wo)
    apart = phi_i - phi_o
    # the azimuth counts as much as it moves the direction nearer the normal; its sign does not
    lever = np.minimum(np.sin(theta_i), np.sin(theta_o))
    turn = [lever * np.cos(apart), lever * np.abs(np.sin(apart))]
    tree = cKDTree(np.stack([theta_i, theta_o, *turn], axis=1))
    some = slice(None, None, 1 + len(wi) // _ENOUGH)
    distance, partner = tree.query(np.stack([theta_o, theta_i, *turn], axis=1)[some])
    ratio = np.log(np.cos(theta_o) / np.cos(theta_i))
    expected = 0.5 * (ratio[some] - ratio[partner])
    telling: BoolArray = (distance < _SAME_PAIR) & (expected > _UNEQUAL)
    change = (log_value[some] - log_value[partner])[telling]
    return np.asarray(change / expected[telling])


def _rank_correlation(a: FloatArray, b: FloatArray) -> float:
    ranks = [np.argsort(np.argsort(x, kind="stable"), kind="stable") for x in (a, b)]
    return float(np.corrcoef(ranks[0], ranks[1])[0, 1])
