"""A sphere under an environment: directions drawn from the light and from the BRDF.

Of the light that a pixel sends to the viewer,

    L = integral f_r(wi, wo) E(wi) cos(theta_i) d(omega_i),

half of the directions are drawn where the environment is bright, half where the BRDF is, and
each is weighted by the density of both together (the balance heuristic): a small sun on a matte
sphere and a mirror under an overcast sky are both seen with few. The points are a fixed
sequence, shifted from pixel to pixel by a fixed table: the same picture every time.

References: E. Veach, L. J. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo
Rendering", SIGGRAPH 1995 (the weights); M. Roberts, "The Unreasonable Effectiveness of
Quasirandom Sequences", 2018 (the points).
"""

from __future__ import annotations

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.progress import Progress, silent
from brdfit.render.environment import Environment
from brdfit.render.lobe import Lobe
from brdfit.render.sphere import Sphere, in_channels

__all__ = ["shade_under"]

# The plastic number's powers: the fractional parts of their multiples fill the square evenly.
_STEP = np.array([0.7548776662466927, 0.5698402909980532])
_SEED = 20260101
_PAIRS = 60_000
_HORIZON = 1e-6


def shade_under(
    sphere: Sphere,
    brdf: Evaluable,
    environment: Environment,
    samples: int = 128,
    progress: Progress = silent,
) -> FloatArray:
    """Return the linear image (size, size, channels), 0 beside the disk.

    `samples` is the number of directions per pixel, half of either kind; noise falls with its
    square root or faster. Three channels are lit by R, G and B, any other number by luminance.
    """
    if samples < 2:
        raise UsageError(f"samples: found {samples} but a pixel needs 2 or more.")
    half = samples // 2
    lobe = Lobe.of(brdf)
    points = np.mod(0.5 + (np.arange(half) + 1)[:, None] * _STEP, 1.0)
    shift = np.random.default_rng(_SEED).random((len(sphere.normal), 2, 2))
    per_chunk = max(1, _PAIRS // (2 * half))
    parts = []
    total = len(sphere.normal)
    for first in range(0, total, per_chunk):
        progress("shading", first, total)
        rows = slice(first, first + per_chunk)
        parts.append(_shade(sphere.frame[rows], shift[rows], points, lobe, brdf, environment))
    progress("shading", total, total)
    return sphere.image(np.concatenate(parts))


def _shade(
    frame: FloatArray,
    shift: FloatArray,
    points: FloatArray,
    lobe: Lobe,
    brdf: Evaluable,
    environment: Environment,
) -> FloatArray:
    """Return (pixels, channels) for pixels of `frame` (pixels, 3, 3)."""
    pixels, half = len(frame), len(points)
    # the viewer stands at +z of the view, in each pixel's frame
    viewer = np.repeat(frame[:, :, 2], half, axis=0)
    u = np.mod(points[None, :, None, :] + shift[:, None, :, :], 1.0)
    of_light = environment.draw(u[:, :, 0].reshape(-1, 2)).reshape(pixels, half, 3)
    from_light = np.einsum("pij,psj->psi", frame, of_light).reshape(-1, 3)
    from_brdf = lobe.draw(viewer, u[:, :, 1].reshape(-1, 2))
    wi, wo = np.vstack([from_light, from_brdf]), np.vstack([viewer, viewer])
    pixel = np.tile(np.repeat(np.arange(pixels), half), 2)
    up = (wi[:, 2] > _HORIZON) & (wo[:, 2] > _HORIZON)
    wi, wo, pixel = wi[up], wo[up], pixel[up]
    outside = np.einsum("nij,ni->nj", frame[pixel], wi)
    density = half * (environment.density(outside) + lobe.density(wi, wo))
    value = brdf.evaluate(wi, wo)
    light = in_channels(environment.look(outside), value.shape[1])
    value = value * light * (wi[:, 2] / density)[:, None]
    columns = [np.bincount(pixel, weights=column, minlength=pixels) for column in value.T]
    return np.stack(columns, axis=1)
