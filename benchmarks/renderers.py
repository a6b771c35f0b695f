"""What arrives in Mitsuba 3 of the tables of real files, as a `.bsdf` and through the plugin.

    python benchmarks/renderers.py --data DIR [-o benchmarks/results/renderers.json]

`DIR` holds rgl/*.bsdf and environments/studio.exr. Each file is read as a table, written as a
`.bsdf`, and opened by Mitsuba's own `measured`. A file that is in the result already, with the
same content and the same code, is not done again. The page goes beside the result.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

import brdfit
import brdfit.mitsuba
from brdfit.albedo import directional_albedo
from brdfit.arrays import FloatArray
from brdfit.bench.ledger import figure, versions
from brdfit.bench.markdown import Column, table
from brdfit.files import atomic_path, sha256_of_file
from brdfit.metrics import perceptual_error
from brdfit.mitsuba.sphere import render_sphere, rendering, sphere_scene
from brdfit.render import Environment, Sphere, shade_under
from brdfit.report.environment_file import read_environment
from brdfit.table import Table

Record = dict[str, Any]
Material = Callable[[], Any]

SEED = 1
PAIRS = 40_000
LIMITS = (80.0, 87.0)
INCIDENCES = (0.0, 20.0, 40.0, 60.0, 75.0, 80.0)
DRAWN = 2**20
SIZE, FINE, RAYS, OURS = 64, 2, 1024, 256
TIMED_SIZE, TIMED_RAYS, REPEATS = 256, 64, 3


def main() -> None:
    """Measure what is not there yet, and leave the result and its page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of real measurements")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("benchmarks/results/renderers.json")
    )
    arguments = parser.parse_args()
    light = arguments.data / "environments" / "studio.exr"
    made = versions() | {"mitsuba": _mitsuba_version()}
    known = json.loads(arguments.output.read_text()) if arguments.output.exists() else {}
    header = {"benchmark": "renderers", "light": sha256_of_file(light), "versions": made}
    same = all(known.get(key) == value for key, value in header.items())
    records: dict[str, Record] = known["records"] if same else {}
    warnings.simplefilter("ignore")
    environment = read_environment(light)
    for path in sorted((arguments.data / "rgl").glob("*.bsdf")):
        digest = sha256_of_file(path)
        if records.get(path.name, {}).get("sha256") == digest:
            continue
        started = time.perf_counter()
        records[path.name] = {"sha256": digest} | measure(brdfit.read_table(path), environment)
        print(f"{path.name} {time.perf_counter() - started:.0f} s", flush=True)
        result = header | {"records": records}
        for file, text in (
            (arguments.output, json.dumps(result, indent=1) + "\n"),
            (arguments.output.with_suffix(".md"), page(records)),
        ):
            with atomic_path(file) as aside:
                aside.write_text(text, encoding="utf-8")


def measure(source: Table, environment: Environment) -> Record:
    """Return the figures of one table."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "written.bsdf"
        brdfit.write_table(source, path)
        measured: Material = lambda: _mitsuba().load_dict(  # noqa: E731
            {"type": "measured", "filename": str(path)}
        )
        plugin: Material = lambda: brdfit.mitsuba.bsdf(source)  # noqa: E731
        with rendering():
            differences = {
                f"log_difference_{limit:.0f}": _difference(source, measured(), limit)
                for limit in LIMITS
            }
            weights = _weights(source, measured())
        times = _seconds({"measured": measured, "plugin": plugin}, environment)
        return (
            {"mebibytes": figure(path.stat().st_size / 2**20, 3)}
            | differences
            | weights
            | _pictures(source, measured, plugin, environment)
            | times
        )


def _difference(source: Table, bsdf: Any, limit: float) -> float | None:
    """Return the mean |delta ln f|: pairs no farther from the normal than `limit` degrees."""
    mi = _mitsuba()
    rng = np.random.default_rng(SEED)
    cosine = rng.uniform(np.cos(np.deg2rad(limit)), 1.0, (2, PAIRS))
    azimuth = rng.uniform(-np.pi, np.pi, (2, PAIRS))
    wi, wo = brdfit.directions_from_spherical(np.arccos(cosine), azimuth)
    si = _interaction(wi, PAIRS)
    found = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wo.T.astype(np.float32)))).T
    found, expected = found / wo[:, 2:], source.evaluate(wi, wo)
    both = (found > 0.0) & (expected > 0.0)
    return figure(np.abs(np.log(found[both] / expected[both])).mean(), 4)


def _weights(source: Table, bsdf: Any) -> Record:
    """Return how far the mean weights of drawn directions are from the directional albedo."""
    mi = _mitsuba()
    angles = np.deg2rad(INCIDENCES)
    expected = directional_albedo(source, angles, rings=240, spokes=48)
    # Scrambled Sobol points: as many random ones leave the mean of a dark channel unsettled.
    points = qmc.Sobol(3, rng=SEED).random(DRAWN).astype(np.float32).T
    found = []
    for angle in angles:
        wi = np.array([np.sin(angle), 0.0, np.cos(angle)])
        _, weight = bsdf.sample(
            mi.BSDFContext(), _interaction(wi, DRAWN), mi.Float(points[0]), mi.Point2f(points[1:])
        )
        found.append(np.array(weight, dtype=np.float64).mean(axis=1))
    off = np.abs(np.array(found) - expected)
    own, brightest = off / np.abs(expected), off / np.abs(expected).max(axis=1, keepdims=True)
    worst = np.unravel_index(int(np.argmax(own)), own.shape)
    return {
        "weights_off_channel": figure(own.max(), 3),
        "weights_off_brightest": figure(brightest.max(), 3),
        "worst_channel": "RGB"[worst[1]],
        "worst_incidence": INCIDENCES[worst[0]],
        "worst_albedo": figure(expected[worst], 3),
    }


def _pictures(
    source: Table, measured: Material, plugin: Material, environment: Environment
) -> Record:
    """Return mean CIEDE2000 between spheres under the panorama, and that of noise alone."""
    fine = Sphere(SIZE * FINE)
    ours = _coarse(shade_under(fine, source, environment, OURS))
    mask = _coarse(fine.mask[..., None].astype(float))[..., 0] == 1.0
    theirs = render_sphere(plugin, environment, SIZE, RAYS)
    again = render_sphere(plugin, environment, SIZE, RAYS, seed=1)
    other = render_sphere(measured, environment, SIZE, RAYS)
    return {
        "measured_and_plugin": figure(perceptual_error(theirs, other, mask), 3),
        "preview_and_plugin": figure(perceptual_error(theirs, ours, mask), 3),
        "noise": figure(perceptual_error(theirs, again, mask), 3),
    }


def _seconds(materials: dict[str, Material], environment: Environment) -> Record:
    """Return the shortest of several renders of each, in turns, both warmed up."""
    found: dict[str, float] = {}
    with rendering() as mi:
        scenes = {
            name: mi.load_dict(sphere_scene(mi, material(), environment, TIMED_SIZE))
            for name, material in materials.items()
        }
        for repeat in range(REPEATS + 1):
            for name, scene in scenes.items():
                started = time.perf_counter()
                np.asarray(mi.render(scene, spp=TIMED_RAYS, seed=repeat))
                if repeat:
                    taken = time.perf_counter() - started
                    found[name] = min(found.get(name, taken), taken)
    return {
        "seconds_measured": figure(found["measured"], 3),
        "seconds_plugin": figure(found["plugin"], 3),
        "time_ratio": figure(found["plugin"] / found["measured"], 3),
    }


def page(records: dict[str, Record]) -> str:
    """Return the tables."""
    shown = {
        "MiB": "mebibytes",
        "80°": "log_difference_80",
        "87°": "log_difference_87",
        "weights": "weights_off_channel",
        "of brightest": "weights_off_brightest",
        "`measured`": "measured_and_plugin",
        "preview": "preview_and_plugin",
        "noise": "noise",
        "time": "time_ratio",
    }
    rows = [
        [name.removesuffix("_rgb.bsdf"), *(f"{record[key]:.4g}" for key in shown.values())]
        for name, record in sorted(records.items())
    ]
    worst = [max(record[key] for record in records.values()) for key in shown.values()]
    rows.append(["**worst**", *(f"**{value:.4g}**" for value in worst)])
    blocks = [
        "# Renderers",
        "Made by `python benchmarks/renderers.py --data DIR`: tables of RGL's files, written by "
        "brdfit as `.bsdf`, opened by `measured` of Mitsuba 3 (`llvm_ad_rgb`).",
        table([Column("file"), *(Column(title, True) for title in shown)], rows).rstrip(),
        f"80°, 87°: mean |delta ln f| of `measured` against the table, {PAIRS:,} pairs even over "
        f"solid angle, no farther from the normal. weights: mean weight of {DRAWN:,} directions "
        f"that `measured` draws from scrambled Sobol points, against the directional albedo, the "
        f"worst of {len(INCIDENCES)} incidences "
        f"({', '.join(f'{a:.0f}' for a in INCIDENCES)} degrees) and "
        f"three channels, relative to the channel's albedo; of brightest: relative to that of the "
        f"brightest channel. Mean CIEDE2000 of spheres of {SIZE} x {SIZE} pixels under studio.exr, "
        f"{RAYS} rays a pixel: `measured` against our plugin, our own preview ({OURS} directions, "
        f"{FINE} x {FINE} as fine) against our plugin, and two renders that differ in their seed. "
        f"time: of {TIMED_SIZE} x {TIMED_SIZE} pixels at {TIMED_RAYS} rays, our plugin over "
        f"`measured`, warm, the shortest of {REPEATS}, on two cores that other work shared.",
    ]
    return "\n\n".join(blocks) + "\n"


def _coarse(image: FloatArray) -> FloatArray:
    side = len(image) // FINE
    return np.asarray(image.reshape(side, FINE, side, FINE, -1).mean(axis=(1, 3)))


def _interaction(wi: FloatArray, n: int) -> Any:
    import drjit

    mi = _mitsuba()
    si = drjit.zeros(mi.SurfaceInteraction3f, n)
    si.wi = mi.Vector3f(np.broadcast_to(wi, (n, 3)).T.astype(np.float32))
    return si


def _mitsuba() -> Any:
    from brdfit.mitsuba.library import mitsuba_library

    return mitsuba_library()


def _mitsuba_version() -> str:
    return str(_mitsuba().__version__)


if __name__ == "__main__":
    main()
