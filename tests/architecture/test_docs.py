"""What the documentation says of the project is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from source_tree import ROOT, package_modules, tracked_files

PAGES = [path for path in tracked_files() if path.suffix == ".md"]
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_relative_link_leads_somewhere(page: Path) -> None:
    targets = LINK.findall(page.read_text(encoding="utf-8"))
    relative = [target for target in targets if "://" not in target]
    assert [target for target in relative if not (page.parent / target).exists()] == []


def test_contributing_draws_every_unit_on_its_floor() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    drawn = dict(re.findall(r"^([0-7])  (.+)$", text, re.MULTILINE))
    units = {m.unit for m in package_modules() if m.unit not in ("", "__main__")}
    assert len(drawn) == 8
    words = {unit for line in drawn.values() for unit in re.findall(r"\w+", line.split("   ")[0])}
    assert units - words == set()


def test_the_commands_of_contributing_are_targets_of_make() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    named = set(re.findall(r"^make (\w+)", text, re.MULTILINE))
    assert named == {"test", "lint", "types", "demo"}
    assert named <= targets


def test_the_license_and_version_are_told_alike_everywhere() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    for pattern in (r'^version[:=\s]+"?([\w.]+)"?$', r'^license[:=\s]+"?([\w.]+)"?$'):
        said = [re.findall(pattern, text, re.MULTILINE) for text in (project, citation)]
        assert len(said[0]) == 1
        assert said[0] == said[1]
