"""The Chromium of this machine, driven headless with WebGL2 in software: for the tests."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Tab", "chromium_path", "launched"]

_NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")

_FLAGS = (
    "--no-sandbox",  # a container's root has no other way
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)


def chromium_path() -> str | None:
    """Return the browser's path: that of BRDFIT_CHROMIUM, or the first of the usual names."""
    named = os.environ.get("BRDFIT_CHROMIUM")
    return named or next(filter(None, map(shutil.which, _NAMES)), None)


@contextmanager
def launched(path: str) -> Iterator[Any]:
    """Give a playwright browser; it is closed at the end."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=list(_FLAGS))
        try:
            yield browser
        finally:
            browser.close()


class Tab:
    """A tab that notes what must not happen: errors, and requests to anybody else."""

    def __init__(self, browser: Any, url: str, **context: Any) -> None:
        settings = {"viewport": {"width": 1280, "height": 900}, **context}
        self._context = browser.new_context(**settings)
        self.page = self._context.new_page()
        self.errors: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", self._note)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(url)

    def _note(self, message: Any) -> None:
        # Chromium tells that reading pixels back is slow, which is known
        if message.type in ("error", "warning") and "GPU stall" not in message.text:
            self.errors.append(f"{message.type}: {message.text}")

    def settle(self) -> None:
        """Wait until the picture is as good as it gets."""
        self.page.wait_for_selector("#stage canvas[data-settled]", timeout=60_000)

    def close(self) -> None:
        """Close the tab."""
        self._context.close()
