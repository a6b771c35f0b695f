from __future__ import annotations

import sys
from pathlib import Path

import pytest

import cli_doc

OTHER_WORDS = sys.version_info >= (3, 13)


@pytest.mark.skipif(OTHER_WORDS, reason="argparse lays its help out otherwise from Python 3.13 on")
def test_the_page_is_what_the_commands_say_of_themselves() -> None:
    assert cli_doc.main(["--check"]) == 0, "run: python tools/cli_doc.py"


def test_a_stale_page_is_found_and_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "cli.md"
    page.write_text("old")
    monkeypatch.setattr(cli_doc, "PAGE", page)
    monkeypatch.setattr(cli_doc, "render", lambda: "new")
    assert cli_doc.main(["--check"]) == 1
    assert cli_doc.main([]) == 0
    assert page.read_text() == "new"
