"""The report in a real browser, from disk, with no network: the script runs, nothing complains."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from brdfit.grid import Grid
from brdfit.reconstruct.result import Reconstruction
from brdfit.report.page import write_report
from brdfit.samples import Source

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.mark.slow
def test_the_page_opens_from_disk_without_a_network(
    tmp_path: Path, fit_known: Callable[..., Reconstruction], monkeypatch: pytest.MonkeyPatch
) -> None:
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    monkeypatch.setattr("brdfit.report.page.pictures._SIZE", 12)
    monkeypatch.setattr("brdfit.report.fitted.MERL_GRID", Grid(20, 18, 24))
    known = fit_known()
    name = "<img src=x onerror=document.title=1><script>document.title=2</script>"
    page = tmp_path / "report.html"
    write_report(replace(known, samples=replace(known.samples, source=Source(name=name))), page)
    done = subprocess.run(
        [
            browser,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--proxy-server=127.0.0.1:9",  # nobody listens there
            f"--user-data-dir={tmp_path / 'profile'}",
            "--enable-logging=stderr",
            "--dump-dom",
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    if not done.stdout:
        pytest.skip(f"{browser} does not run here (exit code {done.returncode})")
    assert re.findall(r".*CONSOLE.*", done.stderr) == []
    assert '<html lang="en" class="scripted">' in done.stdout
    drawn = done.stdout.split('id="interactive"')[1].split("</section>")[0]
    assert "plot slice-plot" in drawn
    assert ">10°, measured<" in drawn or ">30°, measured<" in drawn or ">50°, measured<" in drawn
    title = re.findall(r"<title>(.*?)</title>", done.stdout)[0]
    assert title.endswith(": BRDF report")
    assert title.startswith("&lt;img")
