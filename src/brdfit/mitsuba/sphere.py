"""The sphere of `brdfit.render`, rendered by Mitsuba: the same view, the same lights.

Orthographic, seen along -z, x right, y up, radius 1, the picture from -1 to 1 in both. Mitsuba
draws directions at random, so that the picture has noise, which falls with the square root of the
samples; and it draws points within a pixel, so that the edge is smooth where ours is stepped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.mitsuba.library import mitsuba_library, require_llvm
from brdfit.progress import Progress, silent
from brdfit.render import Environment, Illumination

__all__ = ["Light", "render_sphere", "rendering", "sphere_scene"]

Light = Environment | Illumination

VARIANT = "llvm_ad_rgb"
# Rays at a time; points are spread evenly over those of one pixel only.
_MOST_RAYS = 1 << 24


@contextmanager
def rendering(variant: str = VARIANT) -> Iterator[Any]:
    """Give Mitsuba with `variant` set; afterwards the one before is set again."""
    mi = mitsuba_library()
    if variant.startswith("llvm"):
        require_llvm()
    before = mi.variant()
    mi.set_variant(variant)
    try:
        yield mi
    finally:
        if before is not None:
            mi.set_variant(before)


def render_sphere(
    material: Callable[[], Any],
    light: Light,
    size: int = 256,
    samples: int = 256,
    *,
    seed: int = 0,
    progress: Progress = silent,
) -> FloatArray:
    """Return the linear image (size, size, 3) of a sphere, 0 beside it.

    `material` is called with the variant set and returns a BSDF of Mitsuba, for instance
    `lambda: brdfit.mitsuba.bsdf(table)`. `samples` is the number of rays per pixel.
    """
    if size < 2 or samples < 1:
        raise UsageError(
            f"render_sphere: found size {size} and samples {samples} but a picture has at least "
            f"2 pixels along an edge, and 1 ray per pixel."
        )
    with rendering() as mi:
        scene = mi.load_dict(sphere_scene(mi, material(), light, size))
        return _averaged(mi, scene, size, samples, seed, progress)


def sphere_scene(mi: Any, material: Any, light: Light, size: int) -> dict[str, Any]:
    """Return the scene as Mitsuba's dictionary; directly lit, since nothing else is there."""
    toward = mi.ScalarTransform4f().look_at(origin=[0, 0, 3], target=[0, 0, 0], up=[0, 1, 0])
    return {
        "type": "scene",
        "integrator": {"type": "direct", "hide_emitters": True},
        "sensor": {
            "type": "orthographic",
            "to_world": toward,
            "film": {
                "type": "hdrfilm",
                "width": size,
                "height": size,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
            },
            "sampler": {"type": "multijitter"},
        },
        "sphere": {"type": "sphere", "bsdf": material},
        **_emitters(mi, light),
    }


def _emitters(mi: Any, light: Light) -> dict[str, Any]:
    if isinstance(light, Environment):
        # Mitsuba has -z at the left edge of the panorama, we have it in the middle
        turn = 180.0 - np.degrees(light.turned)
        radiance = np.ascontiguousarray(light.radiance, dtype=np.float32)
        return {
            "environment": {
                "type": "envmap",
                "bitmap": mi.Bitmap(radiance),
                "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], turn),
            }
        }
    emitters: dict[str, Any] = {
        f"light_{index}": {
            "type": "directional",
            "direction": [-float(x) for x in toward],
            "irradiance": {"type": "rgb", "value": irradiance.tolist()},
        }
        for index, (toward, irradiance) in enumerate(
            zip(light.direction, light.irradiance, strict=True)
        )
    }
    if any(light.surround):
        surround = {"type": "rgb", "value": list(light.surround)}
        emitters["surround"] = {"type": "constant", "radiance": surround}
    return emitters


def _averaged(
    mi: Any, scene: Any, size: int, samples: int, seed: int, progress: Progress
) -> FloatArray:
    """Return the mean of as many renders as memory asks for, each with a seed of its own."""
    at_once = max(1, min(samples, _MOST_RAYS // size**2))
    total = np.zeros((size, size, 3))
    done = 0
    progress("rendering", 0, samples)
    while done < samples:
        now = min(at_once, samples - done)
        # (seed, pass) -> a number of its own, in 32 bits
        number = (seed * 100_003 + done) % (1 << 32)
        total += now * np.asarray(mi.render(scene, spp=now, seed=number), dtype=np.float64)
        done += now
        progress("rendering", done, samples)
    return total / samples
