"""Files whose columns do not speak for themselves: declared on the page, as on the command line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import brdfit
from brdfit.viewer.serve import Server
from brdfit.viewer.workbench import Workbench

from chromium import Tab, chromium_path, launched
from viewer_client import Client


@pytest.fixture
def mute_csv(lobe_csv: Path) -> Path:
    """Return the lobe's measurements in radians without a word about it, ';' between them."""
    rows = np.loadtxt(lobe_csv, delimiter=",", skiprows=2)
    rows[:, :4] = np.radians(rows[:, :4])
    path = lobe_csv.with_name("mute.csv")
    np.savetxt(path, rows, delimiter=";", fmt="%.9g")
    return path


SAID = {"directions": "1,2,3,4", "values": "5,6,7", "angles": "radians", "delimiter": ";"}


def test_what_is_said_reaches_the_reader(ask: Client, bench: Workbench, mute_csv: Path) -> None:
    content = mute_csv.read_bytes()
    refused = ask("api/uploads?name=mute.csv", "POST", content)
    assert refused.code == 400
    assert "directions" in refused.json["message"]
    said = "&".join(f"{name}={text}" for name, text in SAID.items())
    upload = ask(f"api/uploads?name=mute.csv&{said}", "POST", content).json
    read = bench.store.get(upload["id"]).samples
    expected = brdfit.read_samples(mute_csv, **SAID)
    np.testing.assert_array_equal(read.value, expected.value)
    np.testing.assert_array_equal(read.wi, expected.wi)


def test_the_form_has_all_that_the_command_line_has(ask: Client) -> None:
    names = {one["name"] for one in ask("api/home").json["reading"]}
    assert {"directions", "values", "angles", "coordinates", "light", "cosine_weighted"} <= names


def test_a_number_that_is_none_is_refused_and_leaves_nothing(
    ask: Client, bench: Workbench, mute_csv: Path
) -> None:
    answer = ask("api/uploads?name=a.csv&wavelength=green", "POST", mute_csv.read_bytes())
    assert answer.code == 400
    assert "expected a number" in answer.json["message"]
    assert list(bench.store.folder.iterdir()) == []


@pytest.fixture
def tab(server: Server) -> Iterator[Any]:
    """Return the page in a browser; it may meet no error but a refused upload."""
    pytest.importorskip("playwright", reason="the browser tests need playwright (extra dev)")
    path = chromium_path()
    if path is None:
        pytest.skip("no Chromium: apt-get install chromium, or BRDFIT_CHROMIUM=PATH")
    with launched(path) as browser:
        one = Tab(browser, server.url)
        yield one
        one.close()
    # Chromium notes every answer of 4xx on its console; ours says in words what was wrong
    assert [error for error in one.errors if "Failed to load resource" not in error] == []


@pytest.mark.usefixtures("full_tables")
def test_a_dropped_file_that_does_not_say_its_columns_asks_for_them(
    tab: Any, bench: Workbench, mute_csv: Path
) -> None:
    page = tab.page
    page.locator("#file").set_input_files(mute_csv)
    page.get_by_role("button", name="Say what its columns mean…").click()
    form = page.locator("dialog.declare")
    assert "mute.csv" in form.locator("h2").inner_text()
    assert "directions" in form.locator(".problem").inner_text()
    first = mute_csv.read_text().splitlines()[0]
    assert f"1  {first}" in form.locator("pre").inner_text()
    # by keyboard: what has the focus is the first field
    form.get_by_label("directions").first.fill(SAID["directions"])
    form.get_by_label("values").first.fill("5,6,77")
    form.get_by_label("angles").select_option("radians")
    form.get_by_text("More").click()
    form.get_by_label("others").fill("delimiter=;")
    page.keyboard.press("Tab")
    form.get_by_role("button", name="Read it").click()
    form.locator(".problem", has_text="77").wait_for()
    form.get_by_label("values").first.fill(SAID["values"])
    page.keyboard.press("Enter")
    page.wait_for_selector("button[data-entry]", timeout=60_000)
    assert page.locator("dialog").count() == 0
    entry = page.locator("button[data-entry]").get_attribute("data-entry")
    judged = bench.store.item(entry).fitted.judged
    assert judged is not None
    assert len(judged.samples) == 90
    assert int(judged.outliers.sum()) == 1


def test_the_form_can_be_left_with_escape(tab: Any, mute_csv: Path) -> None:
    page = tab.page
    page.locator("#file").set_input_files(mute_csv)
    page.get_by_role("button", name="Say what its columns mean…").click()
    page.wait_for_selector("dialog[open]")
    page.keyboard.press("Escape")
    page.wait_for_selector("dialog", state="detached")
