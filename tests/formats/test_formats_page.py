"""The page on formats says what the data sheets say."""

from __future__ import annotations

import re
import tomllib

import pytest

import brdfit
import formats_doc
from brdfit.formats.declaration import Declaration


def test_the_generated_parts_are_up_to_date() -> None:
    page = formats_doc.PAGE.read_text(encoding="utf-8")
    assert formats_doc.render(page) == page, "run: python tools/formats_doc.py"


def test_a_page_out_of_date_is_noticed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    assert formats_doc.main(["--check"]) == 0
    page = formats_doc.PAGE.read_text(encoding="utf-8")
    stale = tmp_path / "formats.md"  # type: ignore[operator]
    stale.write_text(page.replace("| `astm` |", "| `asm` |"), encoding="utf-8")
    monkeypatch.setattr(formats_doc, "PAGE", stale)
    assert formats_doc.main(["--check"]) == 1
    assert "out of date" in capsys.readouterr().err
    assert formats_doc.main([]) == 0
    assert stale.read_text(encoding="utf-8") == page


def test_every_format_and_every_key_is_on_the_page() -> None:
    page = formats_doc.PAGE.read_text(encoding="utf-8")
    for sheet in brdfit.list_formats():
        assert f"### {sheet.name}: " in page
    for key in Declaration.option_names():
        assert f"`{key}`" in page


def test_the_sidecar_on_the_page_is_a_valid_declaration() -> None:
    page = formats_doc.PAGE.read_text(encoding="utf-8")
    (toml,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    declaration = Declaration.from_options(tomllib.loads(toml), "the page")
    assert declaration.coordinates == "spherical"
