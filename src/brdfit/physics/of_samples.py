"""The checks of scattered measurements."""

from __future__ import annotations

from typing import Any

import numpy as np

from brdfit.albedo import albedo_rule
from brdfit.arrays import BoolArray, FloatArray, IntArray, normalize
from brdfit.physics.alignment import find_alignment
from brdfit.physics.finding import Finding, Verdict
from brdfit.physics.neighbourhood import Neighbourhood, mean_of_channels
from brdfit.physics.verdicts import (
    GRAZING,
    alignment_finding,
    cannot,
    energy_finding,
    graded,
    noise_finding,
    reciprocity_finding,
    symmetry_finding,
)
from brdfit.samples import Samples

__all__ = ["sample_findings"]

# Share of the values at or under the noise floor, or unusable: (good below, wrong above).
_LOST = (0.02, 0.3)
_UNUSABLE = ("not_finite", "below_horizon", "not_unit", "unreadable", "rejected")
_ENOUGH = 10
# Degrees within which two samples are at one place; the closest that gives enough pairs.
_WITHIN = (0.25, 0.5, 1.0)
_NEIGHBOURS = 14
_NOISE_SAMPLES = 4000
# A scan of one light direction that says something of the hemisphere.
_SCAN = 20
_SAME_LIGHT = np.radians(1.0)
_NOTHING = 1e-6


def sample_findings(samples: Samples) -> tuple[Finding, ...]:
    """Return what every check finds in `samples`."""
    near = Neighbourhood.of(samples)
    if len(near) < _ENOUGH:
        why = f"only {len(near)} samples are usable and positive"
        names = ("reciprocity", "energy", "grazing", "symmetry", "peak")
        return (_cells(samples), *(cannot(name, why) for name in names))
    return (
        _cells(samples),
        _reciprocity(near),
        _energy(samples),
        _grazing(near),
        _symmetry(near),
        _peak(samples),
    )


def _cells(samples: Samples) -> Finding:
    unusable = ~samples.usable.any(axis=1)
    value = np.where(samples.usable, samples.value, 1.0)
    lost = ~samples.usable | (value <= 0.0)
    # of 31 bands one may be dark: the share is of values, not of samples that have some
    share = float(lost.mean()) if lost.size else 1.0
    details = {
        "unusable": int(unusable.sum()),
        "negative": int((value < 0.0).any(axis=1).sum()),
        "zero": int((value == 0.0).any(axis=1).sum()),
        "lost_by_channel": dict(zip(samples.channels, lost.mean(axis=0).tolist(), strict=True))
        if len(samples)
        else {},
        "most_negative": float(min(value.min(initial=0.0), 0.0)),
        "flags": samples.flag_counts(),
    }
    sentence = _cells_in_words(samples, details, share)
    verdict = graded(share, _LOST)
    if verdict is Verdict.WRONG and np.all(value >= 0.0) and not unusable.any():
        verdict = Verdict.LOOK  # dark under the noise floor: no fault of anybody
    return Finding("cells", verdict, sentence, share, "share of values", details)


def _cells_in_words(samples: Samples, details: dict[str, Any], share: float) -> str:
    n = len(samples)
    if share == 0.0:
        return f"all {n:,} samples can be used, and no value is zero or negative"
    parts = []
    if details["unusable"]:
        why = ", ".join(
            f"{count:,} {flag.replace('_', ' ')}"
            for flag, count in details["flags"].items()
            if flag in _UNUSABLE
        )
        parts.append(f"{details['unusable']:,} cannot be used ({why})")
    if details["negative"]:
        low = details["most_negative"]
        parts.append(f"{details['negative']:,} hold a negative value (down to {low:.3g} 1/sr)")
    if details["zero"]:
        parts.append(f"{details['zero']:,} hold a zero")
    text = f"of {n:,} samples {', '.join(parts)}: in all {share:.1%} of the values"
    if samples.n_channels > 1:
        worst, most = max(details["lost_by_channel"].items(), key=lambda item: item[1])
        text += f", most in {worst}, where it is {most:.0%}"
    return text


def _reciprocity(near: Neighbourhood) -> Finding:
    for within in _WITHIN:
        pairs = near.swapped(np.radians(within))
        if pairs.size >= _ENOUGH:
            return reciprocity_finding(pairs, within)
    return cannot(
        "reciprocity",
        "no direction was measured with light and detector exchanged (fewer than "
        f"{_ENOUGH} pairs within {_WITHIN[-1]:g} degrees)",
    )


def _symmetry(near: Neighbourhood) -> Finding:
    for within in _WITHIN:
        pairs = near.mirrored(np.radians(within))
        if pairs.size >= _ENOUGH:
            high = float(np.percentile(pairs, 95.0))
            what = f"pairs within {within:g} degrees"
            return symmetry_finding(float(np.median(pairs)), high, pairs.size, what)
    return cannot("symmetry", "only one side of the plane of incidence was measured")


def _grazing(near: Neighbourhood) -> Finding:
    grazing = near.larger_angle > np.radians(GRAZING)
    if grazing.sum() < 2 * _NEIGHBOURS or len(near) < 4 * _NEIGHBOURS:
        return cannot("grazing", f"too few samples beyond {GRAZING:g} degrees")
    inside = _scatter(near, near.larger_angle < np.radians(60.0))
    return noise_finding(_scatter(near, grazing), inside, int(grazing.sum()))


def _scatter(near: Neighbourhood, where: BoolArray) -> float:
    rows = np.flatnonzero(where)
    if rows.size < _NEIGHBOURS:
        return 0.0
    rows = rows[:: max(1, rows.size // _NOISE_SAMPLES)]
    return float(1.4826 * np.median(np.abs(near.unexplained(rows, _NEIGHBOURS))))


def _peak(samples: Samples) -> Finding:
    found = find_alignment(samples)
    if found is None:
        return cannot("peak", "no specular peak is to be seen near the mirror directions")
    what = {
        "incidence": "in the plane of incidence: the zero of an arm",
        "sample": "fixed to the sample: its tilt",
        "either": "a tilt of the sample or the zero of an arm",
    }[found.frame]
    details: dict[str, object] = {
        "along_degrees": found.along,
        "across_degrees": found.across,
        "uncertainty_degrees": found.uncertainty,
        "frame": found.frame,
        "samples": found.samples,
    }
    return alignment_finding(found.degrees, found.uncertainty, what, details)


def _energy(samples: Samples) -> Finding:
    theta, albedo, covered = [], [], []
    for angle, rows in _scans(samples):
        found = _scan_albedo(samples, rows, angle)
        if found is not None:
            theta.append(angle)
            albedo.append(found[0])
            covered.append(found[1])
    if not theta:
        return cannot(
            "energy",
            "no light direction was scanned over enough of the hemisphere: fit a table and ask it",
        )
    return energy_finding(np.array(theta), np.stack(albedo), samples.channels, np.array(covered))


def _scans(samples: Samples) -> list[tuple[float, IntArray]]:
    """Return (theta_i, rows) of every light direction with enough samples."""
    rows = np.flatnonzero(samples.usable.all(axis=1) & (mean_of_channels(samples) > 0.0))
    theta = np.arccos(np.clip(samples.wi[rows, 2], -1.0, 1.0))
    order = np.argsort(theta)
    breaks = np.flatnonzero(np.diff(theta[order]) > _SAME_LIGHT / 4.0) + 1
    groups = np.split(order, breaks)
    return [
        (float(theta[group].mean()), rows[group])
        for group in groups
        if group.size >= _SCAN and np.ptp(theta[group]) <= _SAME_LIGHT
    ]


def _scan_albedo(
    samples: Samples, rows: IntArray, theta_i: float
) -> tuple[FloatArray, float] | None:
    """Return (albedo (channels,), covered share) over what the scan encloses; None of a line."""
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError

    wi, wo, weight = albedo_rule(theta_i)
    plane = _warped(wi[None, :], wo)
    known = _warped(samples.wi[rows], samples.wo[rows])
    # an isotropic surface is taken for the same on both sides of the plane of incidence
    both = np.vstack([known, known * (1.0, -1.0)])
    if np.ptp(both[:, 1]) < 0.1:
        return None
    f = np.vstack([samples.value[rows]] * 2)
    # ln, so that a lobe keeps its shape between samples; what is not positive counts as nothing
    log_f = np.log(np.maximum(f, _NOTHING * f.max(axis=0)))
    try:
        value = np.exp(LinearNDInterpolator(both, log_f)(plane))
    except QhullError:
        return None
    inside = np.isfinite(value).all(axis=1)
    share = float(weight[inside].sum() / weight.sum())
    return weight[inside] @ value[inside], share


def _warped(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Half vectors laid into the plane, light at azimuth 0, radius sqrt(theta_h): lobes widen."""
    azimuth = np.arctan2(wi[:, 1], wi[:, 0])
    wh = normalize(wi + wo)
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    x, y = cos * wh[:, 0] + sin * wh[:, 1], cos * wh[:, 1] - sin * wh[:, 0]
    sine = np.hypot(x, y)
    scale = np.sqrt(np.arctan2(sine, wh[:, 2])) / np.maximum(sine, 1e-12)
    return np.stack([x * scale, y * scale], axis=1)
