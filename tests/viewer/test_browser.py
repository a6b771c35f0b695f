"""The page in a real browser, from the file to the pixels.

Runs where Chromium and playwright are installed (`apt-get install chromium`, extra `dev`).
The real measurements come from the shared data; what needs them skips without.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.grid import Grid
from brdfit.reconstruct import Reconstruction
from brdfit.render import MaterialBall, Sphere, area_studio, point, studio
from brdfit.report.compare import compare
from brdfit.report.rgb import rgb_table
from brdfit.viewer.serve import Server
from brdfit.viewer.workbench import Workbench

from chromium import Tab, chromium_path, launched
from page_picture import picture, shown_difference, sphere_of

pytest.importorskip("playwright", reason="the browser tests need playwright (extra dev)")
pytestmark = pytest.mark.skipif(
    chromium_path() is None, reason="no Chromium: apt-get install chromium, or BRDFIT_CHROMIUM=PATH"
)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Return a browser for all tests of this module."""
    path = chromium_path()
    assert path is not None
    with launched(path) as one:
        yield one


@pytest.fixture
def open_tab(browser: Any, server: Server) -> Iterator[Any]:
    """Return a function that opens the page in a tab of its own.

    At the end none may have met an error, or asked anybody but the server.
    """
    tabs: list[Tab] = []

    def call(**context: Any) -> Tab:
        tabs.append(Tab(browser, server.url, **context))
        return tabs[-1]

    yield call
    for tab in tabs:
        tab.close()
    assert [error for tab in tabs for error in tab.errors] == []
    strangers = [url for tab in tabs for url in tab.asked if not url.startswith(server.url)]
    assert [url for url in strangers if not url.startswith(("data:", "blob:"))] == []


@pytest.fixture(scope="module")
def real_fit(request: pytest.FixtureRequest) -> Reconstruction:
    """Return the fit of a real paint of 31 bands."""
    path = request.getfixturevalue("shared_data") / "cornell" / "krylon_blue.astm"
    return brdfit.fit(brdfit.read_samples(path), method=brdfit.LocalBasis())


@pytest.mark.parametrize("light", ["studio", "point", "area_studio"])
def test_the_sphere_is_the_one_that_brdfit_renders(
    open_tab: Any,
    bench: Workbench,
    real_fit: Reconstruction,
    light: str,
) -> None:
    bench.open(real_fit)
    # small: a light takes milliseconds where a processor stands in for the graphics card
    tab = open_tab(viewport={"width": 900, "height": 480})
    tab.settle()
    tab.page.get_by_label("Light", exact=True).select_option(light)
    tab.settle()
    tab.page.wait_for_timeout(300)  # the albedo of the surround comes after the table
    tab.settle()
    shown = sphere_of(tab)
    sphere = Sphere(shown.shape[0])
    rgb, _ = rgb_table(real_fit.table())
    lights = {"studio": studio, "point": point, "area_studio": area_studio}[light]()
    difference = shown_difference(shown, sphere.shade(rgb, lights), sphere)
    print(f"mean CIEDE2000 under {light}: {difference:.3f}")  # shown by pytest -rP
    assert difference < 2.0


def test_the_material_ball_is_the_one_that_brdfit_renders(
    open_tab: Any, bench: Workbench, lobe: Reconstruction
) -> None:
    table = lobe.table(Grid(60, 60, 36))
    bench.open(table)
    tab = open_tab(viewport={"width": 900, "height": 480})
    tab.settle()
    tab.page.get_by_label("Shape").select_option("ball")
    tab.page.get_by_label("Light", exact=True).select_option("point")
    tab.page.wait_for_timeout(300)
    tab.settle()
    shown = sphere_of(tab)
    ball = MaterialBall(shown.shape[0])
    found = shown_difference(shown, ball.shade(table, point()), ball)
    print(f"mean CIEDE2000 of the ball: {found:.3f}")
    assert found < 2.0


@pytest.mark.usefixtures("full_tables")
def test_an_outlier_shows_its_row_and_switching_it_off_and_refitting_changes_the_table(
    open_tab: Any, bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    tab, other = open_tab(), open_tab()
    page = tab.page
    for one in (tab, other):
        one.settle()
    before = picture(other)[0]
    page.locator(".outlier-list button").first.click()
    page.wait_for_selector(".detail h3")
    assert "Row 87 of lobe.csv: outlier" in page.locator(".detail h3").inner_text()
    page.locator(".detail .switch").click()
    page.locator("#tab-fit").click()
    assert "1 samples switched off" in page.locator(".switches").inner_text()
    page.get_by_role("button", name="Fit again").click()
    page.wait_for_selector('button[data-entry="e2"]')
    assert page.locator('button[data-entry="e1"]').count() == 0
    tab.settle()
    assert not np.allclose(bench.store.item("e2").table.values, bench.store.item("e1").table.values)
    # the other tab has not noticed
    assert other.page.locator('button[data-entry="e1"]').count() == 1
    np.testing.assert_array_equal(picture(other)[0], before)
    # and what was refitted is there after a reload
    page.reload()
    page.wait_for_selector('button[data-entry="e2"]')


def test_the_band_of_the_posterior_is_drawn_and_told(
    open_tab: Any, bench: Workbench, sure: Reconstruction
) -> None:
    bench.open(sure)
    page = open_tab().page
    page.locator(".outlier-list button").first.click()
    page.wait_for_selector(".detail tbody tr")
    assert page.locator(".detail tr.outside").count() == 3
    assert " … " in page.locator(".detail tbody td").nth(2).inner_text()
    page.locator("#tab-slices").click()
    page.wait_for_selector(".slice-plot .band")
    for plot in (".slice-plot", ".polar-plot"):
        bands = page.locator(f"{plot} .band").all()
        assert len(bands) == 3
        assert all(band.bounding_box()["height"] > 5 for band in bands)
    assert "The band holds 95 %" in page.locator("#panel-slices .hint").inner_text()


@pytest.mark.usefixtures("full_tables")
def test_a_dropped_file_is_fitted_and_its_binary_downloads_and_reads_back(
    open_tab: Any, bench: Workbench, lobe_csv: Path, tmp_path: Path
) -> None:
    tab = open_tab()
    page = tab.page
    page.wait_for_selector("#bar button")
    dropped = page.evaluate_handle(
        "([name, text]) => { const data = new DataTransfer(); "
        "data.items.add(new File([text], name)); return data; }",
        [lobe_csv.name, lobe_csv.read_text()],
    )
    page.dispatch_event("body", "dragover", {"dataTransfer": dropped})
    assert page.locator("#drop").is_visible()
    page.dispatch_event("body", "drop", {"dataTransfer": dropped})
    page.wait_for_selector("button[data-entry]", timeout=60_000)
    tab.settle()
    page.locator("#tab-samples").click()
    page.locator(".outlier-list button").first.click()
    page.wait_for_selector(".detail .line")
    assert lobe_csv.read_text().splitlines()[86] in page.locator(".detail .line").inner_text()
    page.locator("#tab-fit").click()
    with page.expect_download() as waiting:
        page.locator('a[data-download="table/merl"]').click()
    assert waiting.value.suggested_filename == "lobe.binary"
    waiting.value.save_as(tmp_path / "lobe.binary")
    table = brdfit.read_table(tmp_path / "lobe.binary")
    entry = page.locator("button[data-entry]").get_attribute("data-entry")
    made = bench.store.item(entry).table
    np.testing.assert_allclose(table.values[made.mask], made.values[made.mask], rtol=1e-6)


@pytest.mark.usefixtures("full_tables")
def test_two_entries_stand_side_by_side_and_their_difference_is_the_perceptual_error(
    open_tab: Any, bench: Workbench, lobe: Reconstruction
) -> None:
    table = lobe.table()
    other = brdfit.Table(values=table.values * np.float32(1.3))
    bench.open(table)
    bench.open(other)
    tab = open_tab()
    page = tab.page
    tab.settle()
    # a table alone has no samples: no empty maps
    assert not page.locator("canvas.sample-map").first.is_visible()
    page.get_by_label("Difference").check()
    page.wait_for_selector("canvas[data-difference]", timeout=60_000)
    shown = float(page.locator("#stage canvas").get_attribute("data-difference"))
    expected = compare(table, other, illuminations=("studio",)).perceptual_error
    assert shown == pytest.approx(expected, rel=0.05)
    page.locator("#tab-compare").click()
    page.get_by_role("button", name="Compare").click()
    figure = page.locator('tr[data-metric="perceptual_error/studio"] td').nth(1)
    assert float(figure.inner_text().split()[0]) == pytest.approx(expected, rel=1e-3)


def test_a_fit_can_be_cancelled_and_its_error_read(
    open_tab: Any, bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    page = open_tab().page
    page.locator("#tab-fit").click()
    page.get_by_label("Method").select_option("slow")
    page.get_by_role("button", name="Fit again").click()
    page.wait_for_selector('.job[data-state="running"] progress')
    page.get_by_role("button", name="Cancel").click()
    page.wait_for_selector('.job[data-state="cancelled"]')


@pytest.mark.parametrize(
    ("width", "scheme"), [(380, "light"), (1280, "dark")], ids=["narrow", "dark"]
)
def test_the_page_fits_a_narrow_window_and_the_dark(
    open_tab: Any, bench: Workbench, lobe: Reconstruction, width: int, scheme: str
) -> None:
    bench.open(lobe)
    tab = open_tab(viewport={"width": width, "height": 800}, color_scheme=scheme)
    tab.settle()
    page = tab.page
    for name in ("samples", "slices", "trust", "compare", "fit"):
        page.locator(f"#tab-{name}").click()
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    back = page.evaluate("getComputedStyle(document.body).backgroundColor")
    level = int(back.removeprefix("rgb(").split(",")[0])
    assert (level < 60) == (scheme == "dark")


def test_everything_can_be_reached_and_moved_by_the_keyboard(
    open_tab: Any, bench: Workbench, lobe: Reconstruction
) -> None:
    bench.open(lobe)
    tab = open_tab()
    tab.settle()
    page = tab.page
    before = picture(tab)[0]
    page.locator("#stage canvas").focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    page.wait_for_timeout(400)
    tab.settle()
    assert not np.allclose(picture(tab)[0], before)
    page.locator("#tab-samples").focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("#panel-slices").is_visible()
    page.keyboard.press("ArrowLeft")
    page.locator('canvas[data-map="half"]').focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_selector(".detail h3")
    unnamed = [
        control.evaluate("e => e.outerHTML")
        for control in page.locator("button:visible, select:visible, input:visible").all()
        if not control.evaluate(
            "e => (e.textContent + (e.getAttribute('aria-label') ?? '') + "
            "(e.closest('label')?.textContent ?? '')).trim()"
        )
    ]
    assert unnamed == []
