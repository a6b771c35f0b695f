"""What the viewer and the report cost: first picture, bytes, agreement, frames.

    python benchmarks/viewer.py --data DIR [-o benchmarks/results/viewer.json]

`DIR/cornell/krylon_blue.astm` (31 bands) is fitted by `LocalBasis`; its table is written as a
`.binary` of 35 MB, once as it is and once with 2 % noise in every cell, which no packing makes
small. A headless Chromium, WebGL2 in software, then looks at each:

first picture   from the start of the process `brdfit view FILE --no-browser`, and from the
                navigation to the address that it prints, until something of the table is on the
                canvas, however coarse; and until the picture is as good as it gets. The browser
                runs already; every run is a new process and a new profile. Files are in the
                system's cache.
bytes           the table as it travels, and everything that the page fetches
agreement       mean CIEDE2000 between the middle of the sphere on the page and `Sphere.shade`
frames          pictures a second while the pointer drags the light, without a graphics card
report          size of the report of the same fit, made from its files

The page of tables goes beside the result. Before each opening the script waits, for at most
forty seconds, until others leave the machine alone for half a second; how many cores they kept
busy then stands beside the seconds. What they begin later is in the seconds too.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import brdfit
from brdfit.bench.ledger import figure, versions
from brdfit.bench.markdown import Column, cell, table
from brdfit.files import atomic_path, sha256_of_file
from brdfit.render import ILLUMINATIONS, Sphere
from brdfit.report.fit_outputs import FitPaths, write_fit
from brdfit.report.rgb import rgb_table
from brdfit.viewer.serve import Server
from brdfit.viewer.workbench import Workbench

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tools"))

from chromium import Tab, chromium_path, launched
from page_picture import shown_difference, sphere_of

NOISE = 0.02
SEED = 1
DRAG_SECONDS = 3.0
# Drags the light on every frame of the browser; returns (pictures shown, seconds).
_DRAG = """async (seconds) => {
  const canvas = document.querySelector('#stage canvas');
  const box = canvas.getBoundingClientRect();
  const at = (share) => ({
    clientX: box.left + box.width * (0.4 + 0.2 * share),
    clientY: box.top + box.height * 0.45, pointerId: 1, bubbles: true,
  });
  canvas.setPointerCapture = () => {};
  canvas.dispatchEvent(new PointerEvent('pointerdown', at(0)));
  const [from, before] = [performance.now(), Number(canvas.dataset.frames)];
  let now = from;
  while (now - from < 1000 * seconds) {
    now = await new Promise(requestAnimationFrame);
    canvas.dispatchEvent(new PointerEvent('pointermove', at(Math.sin(now / 300))));
  }
  const shown = Number(canvas.dataset.frames) - before;
  canvas.dispatchEvent(new PointerEvent('pointerup', at(0)));
  return [shown, (performance.now() - from) / 1000];
}"""
_TIMES = """() => {
  const canvas = document.querySelector('#stage canvas');
  const parts = performance.getEntriesByType('resource');
  const table = parts.find((part) => part.name.endsWith('/table'));
  const page = performance.getEntriesByType('navigation')[0];
  return {
    origin: performance.timeOrigin / 1000,
    presented: Number(canvas.dataset.presented) / 1000,
    table: table.encodedBodySize,
    all: parts.reduce((sum, part) => sum + part.transferSize, page.transferSize),
  };
}"""

Record = dict[str, Any]


def main() -> None:
    """Measure, and leave the result and its page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of real measurements")
    parser.add_argument("--repeat", type=int, default=5, help="openings of each table")
    parser.add_argument("-o", "--output", type=Path, default=Path("benchmarks/results/viewer.json"))
    arguments = parser.parse_args()
    chromium = chromium_path()
    if chromium is None:
        parser.error("no Chromium: apt-get install chromium, or BRDFIT_CHROMIUM=PATH")
    source = arguments.data / "cornell" / "krylon_blue.astm"
    with tempfile.TemporaryDirectory() as folder, launched(chromium) as browser:
        result = brdfit.fit(brdfit.read_samples(source), method=brdfit.LocalBasis())
        tables, report = written(result, Path(folder))
        found = {
            "benchmark": "viewer",
            "openings": {
                name: [opened(path, browser) for _ in range(arguments.repeat)]
                for name, path in tables.items()
            },
            "agreement": agreement(result.table(), browser),
            "frames": frames(result.table(), browser),
            "report_bytes": report,
            "machine": {
                "cores": os.cpu_count(),
                "load_average": [round(one, 2) for one in os.getloadavg()],
                "browser": browser.version,
            },
            "inputs": {source.name: sha256_of_file(source)},
            "versions": versions(),
        }
    for path, text in (
        (arguments.output, json.dumps(found, indent=1, sort_keys=True) + "\n"),
        (arguments.output.with_suffix(".md"), page(found)),
    ):
        with atomic_path(path) as aside:
            aside.write_text(text, encoding="utf-8")
    print(page(found))


def written(result: brdfit.Reconstruction, folder: Path) -> tuple[dict[str, Path], int]:
    """Write the tables of 35 MB and the report; return (tables by name, bytes of the report)."""
    fit = FitPaths.beside(folder / "fit.binary")
    made = write_fit(result, fit)
    brdfit.write_report(fit.table, folder / "fit.html")
    rng = np.random.default_rng(SEED)
    values = made.table.values
    noise = np.exp(NOISE * rng.standard_normal(values.shape, dtype=np.float32))
    paths = {"table alone": folder / "table.binary", "2 % noise": folder / "noise.binary"}
    brdfit.write_table(made.table, paths["table alone"])
    brdfit.write_table(brdfit.Table(values=values * noise), paths["2 % noise"])
    return {**paths, "with its fit": fit.table}, (folder / "fit.html").stat().st_size


def opened(path: Path, browser: Any) -> Record:
    """Open a table from the command line and in a fresh tab; return seconds and bytes."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    tab = context.new_page()
    words = [sys.executable, "-m", "brdfit", "view", str(path), "--no-browser"]
    busy = quiet_moment()
    begun = time.time()
    program = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert program.stdout is not None
        url = next(filter(None, (re.match(r"http://\S+", line) for line in program.stdout)))[0]
        tab.goto(url, wait_until="commit")
        tab.wait_for_selector("#stage canvas[data-presented]", timeout=60_000)
        times = tab.evaluate(_TIMES)
        tab.wait_for_selector("#stage canvas[data-settled]", timeout=60_000)
        settled = time.time()
        return {
            "cores_busy_before": busy,
            "megabytes_of_file": figure(path.stat().st_size / 1e6, 4),
            "from_command": figure(times["origin"] + times["presented"] - begun, 3),
            "from_navigation": figure(times["presented"], 3),
            "settled_from_command": figure(settled - begun, 3),
            "table_bytes": times["table"],
            "all_bytes": times["all"],
        }
    finally:
        program.terminate()
        program.wait()
        context.close()


def quiet_moment(patience: float = 40.0) -> float | None:
    """Wait until others leave the machine alone; return how many cores they kept busy at last.

    None, at once, where the system does not say (/proc/stat).
    """
    end = time.monotonic() + patience
    while True:
        before = _busy_seconds()
        if before is None:
            return None
        time.sleep(0.5)
        busy = ((_busy_seconds() or before) - before) / 0.5
        if busy < 0.2 or time.monotonic() > end:
            return figure(busy, 2)


def _busy_seconds() -> float | None:
    try:
        first = Path("/proc/stat").read_text(encoding="ascii").splitlines()[0].split()[1:]
    except OSError:
        return None
    # user, nice, system, idle, iowait, ...
    ticks = [int(one) for one in first]
    return (sum(ticks[:8]) - ticks[3] - ticks[4]) / os.sysconf("SC_CLK_TCK")


def agreement(brdf: brdfit.Table, browser: Any) -> dict[str, float | None]:
    """Return the mean CIEDE2000 of the page's sphere against the library's, by illumination."""
    rgb, _ = rgb_table(brdf)
    found = {}

    def measure(tab: Tab) -> None:
        for light, make in ILLUMINATIONS.items():
            tab.page.get_by_label("Light", exact=True).select_option(light)
            tab.page.wait_for_timeout(1000)  # the albedo of the surround comes after the table
            tab.settle()
            shown = sphere_of(tab)
            sphere = Sphere(shown.shape[0])
            found[light] = figure(shown_difference(shown, sphere.shade(rgb, make()), sphere), 3)

    _looked_at(brdf, browser, measure, width=900, height=480)
    return found


def frames(brdf: brdfit.Table, browser: Any) -> dict[str, float | None]:
    """Return pictures a second while the light is dragged, by illumination."""
    found = {}

    def measure(tab: Tab) -> None:
        for light in ILLUMINATIONS:
            tab.page.get_by_label("Light", exact=True).select_option(light)
            tab.settle()
            shown, seconds = tab.page.evaluate(_DRAG, DRAG_SECONDS)
            found[light] = figure(shown / seconds, 3)
            tab.page.wait_for_timeout(500)
            tab.settle()

    _looked_at(brdf, browser, measure, width=1280, height=900)
    return found


def _looked_at(
    brdf: brdfit.Table, browser: Any, measure: Callable[[Tab], None], **viewport: int
) -> None:
    with Workbench() as bench:
        bench.open(brdf)
        with Server(bench).running() as server:
            tab = Tab(browser, server.url, viewport=viewport)
            try:
                tab.settle()
                measure(tab)
            finally:
                tab.close()


def page(found: Record) -> str:
    """Return the page of tables."""
    machine = found["machine"]
    load = ", ".join(map(str, machine["load_average"]))
    return "\n".join(
        [
            "# The viewer and the report",
            "",
            "Made by `python benchmarks/viewer.py --data DIR`, which says what is measured.",
            f"{machine['cores']} cores, load average {load}, Chromium "
            f"{machine['browser']}, headless, WebGL2 in software. Seconds: median (least to "
            "most) of all openings.",
            "",
            _openings(found["openings"]),
            "",
            "First picture: at most 2 s. Table: at most 12 MB.",
            "",
            _lights(found["agreement"], found["frames"]),
            "",
            "Agreement: mean CIEDE2000 of the page's sphere against the library's; at most 2.",
            "",
            f"Report of the same fit: {found['report_bytes'] / 1e6:.2f} MB; at most 6 MB.",
            "",
        ]
    )


def _openings(openings: dict[str, list[Record]]) -> str:
    columns = [
        Column("opened"),
        Column("first picture, from the command", number=True),
        Column("from the navigation", number=True),
        Column("settled, from the command", number=True),
        Column("table, MB", number=True),
        Column("all, MB", number=True),
        Column("cores busy before", number=True),
    ]
    rows = []
    for name, runs in openings.items():
        times = ("from_command", "from_navigation", "settled_from_command")
        sizes = (max(run[key] for run in runs) / 1e6 for key in ("table_bytes", "all_bytes"))
        rows.append(
            [
                f"{name} ({runs[0]['megabytes_of_file']:.0f} MB)",
                *(_spread([run[key] for run in runs]) for key in times),
                *(cell(size, digits=2) for size in sizes),
                _spread([run["cores_busy_before"] or 0.0 for run in runs]),
            ]
        )
    return table(columns, rows)


def _spread(found: list[float]) -> str:
    return f"{statistics.median(found):.2f} ({min(found):.2f} to {max(found):.2f})"


def _lights(agreement: Record, frames: Record) -> str:
    columns = [
        Column("illumination"),
        Column("agreement, CIEDE2000", number=True),
        Column("pictures a second", number=True),
    ]
    rows = [[name, cell(agreement[name]), cell(frames[name], digits=0)] for name in agreement]
    return table(columns, rows)


if __name__ == "__main__":
    main()
