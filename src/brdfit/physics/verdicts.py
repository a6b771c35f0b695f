"""From figures to verdicts and sentences, alike for samples and tables.

The limits are stated here and nowhere else. They are what careful instruments reach on
painted panels, not laws; the albedo's is a law.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.physics.finding import Finding, Verdict

__all__ = [
    "GRAZING",
    "RECIPROCITY_HELD",
    "alignment_finding",
    "cannot",
    "energy_finding",
    "noise_finding",
    "reciprocity_finding",
    "symmetry_finding",
]

GRAZING = 75.0
"""Degrees of the larger of theta_i and theta_o from which on a value counts as grazing."""

# (good below, wrong above)
_RECIPROCITY = (0.05, 0.25)
_SYMMETRY = (0.05, 0.25)
_NOISE = (0.05, 0.25)
_TILT = (0.3, 2.0)
_ALMOST_ALL = 0.98
# The integral itself is good to a tenth of a percent.
_OVER_ONE = 1.002

RECIPROCITY_HELD = Finding(
    "reciprocity",
    Verdict.GOOD,
    "a table holds one value for both orders of light and detector: whatever the measurement did, "
    "it is reciprocal",
    0.0,
    "median |delta ln f|",
)


def cannot(name: str, why: str) -> Finding:
    """Return the finding that the content cannot answer."""
    return Finding(name, Verdict.UNKNOWN, why)


def graded(figure: float, limits: tuple[float, float]) -> Verdict:
    """Return GOOD below the first limit, WRONG above the second, LOOK between."""
    good, wrong = limits
    return Verdict.GOOD if figure < good else Verdict.WRONG if figure > wrong else Verdict.LOOK


def energy_finding(
    theta: FloatArray, albedo: FloatArray, channels: tuple[str, ...], covered: FloatArray | None
) -> Finding:
    """Return the finding of directional albedos (angles, channels) at `theta`, radians.

    `covered` (angles,) is the cosine-weighted share of the hemisphere that was integrated
    over; None where it was all.
    """
    worst = np.unravel_index(np.argmax(albedo), albedo.shape)
    figure, degrees = float(albedo[worst]), float(np.degrees(theta[worst[0]]))
    over = np.degrees(theta[(albedo > _OVER_ONE).any(axis=1)])
    if figure > _OVER_ONE:
        verdict, meaning = Verdict.WRONG, "more light leaves the surface than arrives"
    elif figure > _ALMOST_ALL:
        verdict, meaning = Verdict.LOOK, "it would all but vanish in a white furnace"
    else:
        verdict, meaning = Verdict.GOOD, "darker than a white furnace everywhere"
    where = f"at {degrees:.0f} degrees of incidence, channel {channels[worst[1]]}"
    sentence = f"directional albedo is at most {figure:.3f} ({where}): {meaning}"
    if over.size:
        sentence += (
            f"; above 1 at {over.size} of {theta.size} angles, from {over.min():.0f} degrees"
        )
    details: dict[str, Any] = {
        "theta_i_degrees": [float(value) for value in np.degrees(theta)],
        "albedo": dict(zip(channels, albedo.T.tolist(), strict=True)),
        "worst_theta_i_degrees": degrees,
        "worst_channel": channels[worst[1]],
        "angles_above_one": int(over.size),
    }
    if covered is not None:
        details["covered"] = [float(share) for share in covered]
        sentence += (
            f"; a lower bound, over the {covered[worst[0]]:.0%} of the hemisphere that was measured"
        )
    return Finding("energy", verdict, sentence, figure, "albedo", details)


def reciprocity_finding(difference: FloatArray, within: float) -> Finding:
    """Return the finding of |delta ln f| (pairs,) of exchanged directions, `within` degrees."""
    figure = float(np.median(difference))
    verdict = graded(figure, _RECIPROCITY)
    meaning = {
        Verdict.GOOD: "as alike as measurements are",
        Verdict.LOOK: "more than noise: look for drift, an unwanted cosine, an anisotropic sample",
        Verdict.WRONG: "the values are not f_r, a direction is misread, or it is anisotropic",
    }[verdict]
    sentence = (
        f"light and detector exchanged change the value by {_percent(figure)} (median of "
        f"{difference.size} pairs within {within:g} degrees): {meaning}"
    )
    details = {
        "pairs": int(difference.size),
        "percentile_95": float(np.percentile(difference, 95.0)),
        "within_degrees": within,
    }
    return Finding("reciprocity", verdict, sentence, figure, "median |delta ln f|", details)


def symmetry_finding(figure: float, high: float, count: int, what: str) -> Finding:
    """Return the finding of |delta ln f| between phi_d and -phi_d: median, 95th percentile."""
    verdict = graded(figure, _SYMMETRY)
    meaning = {
        Verdict.GOOD: "the same on either side of the plane of incidence",
        Verdict.LOOK: "not quite the same on either side of the plane of incidence",
        Verdict.WRONG: "an anisotropic material, or a sample that was tilted",
    }[verdict]
    sentence = (
        f"phi_d and -phi_d differ by {_percent(figure)} (median of {count} {what}): {meaning}"
    )
    details = {"count": count, "percentile_95": high}
    return Finding("symmetry", verdict, sentence, figure, "median |delta ln f|", details)


def noise_finding(grazing: float, inside: float, count: int) -> Finding:
    """Return the finding of the noise of ln f at grazing angles, and that of the rest."""
    verdict = graded(grazing, _NOISE)
    meaning = {
        Verdict.GOOD: "smooth",
        Verdict.LOOK: "rough: trust it less, or measure longer",
        Verdict.WRONG: "mostly noise: do not lean on it",
    }[verdict]
    sentence = (
        f"beyond {GRAZING:g} degrees neighbouring values scatter by {_percent(grazing)}, those of "
        f"the rest by {_percent(inside)}: {meaning}"
    )
    details = {"inside": inside, "count": count, "beyond_degrees": GRAZING}
    return Finding("grazing", verdict, sentence, grazing, "stddev of ln f", details)


def alignment_finding(
    degrees: float, uncertainty: float, what: str, details: Mapping[str, object]
) -> Finding:
    """Return the finding of the distance of the specular peak from the mirror direction."""
    surely = max(0.0, degrees - 2.0 * uncertainty)
    verdict = Verdict.GOOD if surely == 0.0 else graded(surely, _TILT)
    meaning = {
        Verdict.GOOD: "where it belongs, as far as can be told",
        Verdict.LOOK: "off by little, which a narrow lobe already shows",
        Verdict.WRONG: "the sample was tilted, an arm is off its zero, or an angle is misread",
    }[verdict]
    sentence = (
        f"the specular peak stands {degrees:.2f} +- {uncertainty:.2f} degrees from theta_h = 0 "
        f"({what}): {meaning}"
    )
    return Finding("peak", verdict, sentence, degrees, "degrees", dict(details))


def _percent(log_difference: float) -> str:
    return f"{np.expm1(log_difference):.1%}"
