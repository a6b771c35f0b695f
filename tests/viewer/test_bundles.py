"""The committed bundles are of the committed sources."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from brdfit.files import sha256_of_file

from source_tree import ROOT

CLIENT = ROOT / "viewer-client"
PACKAGE = ROOT / "src" / "brdfit"

MANIFESTS = sorted(PACKAGE.glob("*/static/*.sources.json"))


def named_by_the_build() -> set[Path]:
    """Return the bundles that build.mjs writes."""
    text = (CLIENT / "build.mjs").read_text(encoding="utf-8")
    return {PACKAGE / name for name in re.findall(r'out: "([^"]+)"', text)}


def test_every_bundle_has_its_list_of_sources_and_nothing_else_lies_there() -> None:
    listed = {path.with_name(path.name.removesuffix(".sources.json")) for path in MANIFESTS}
    assert listed == named_by_the_build()
    found = {path for path in PACKAGE.glob("*/static/*") if not path.name.endswith(".json")}
    assert found == listed


@pytest.mark.parametrize("manifest", MANIFESTS, ids=lambda path: path.name)
def test_a_bundle_was_made_of_the_sources_as_they_are(manifest: Path) -> None:
    sources = json.loads(manifest.read_text(encoding="utf-8"))
    assert {"build.mjs", "package-lock.json"} < set(sources)
    now = {name: sha256_of_file(CLIENT / name) for name in sources}
    assert now == sources, "run: cd viewer-client && npm ci && npm run build"


def test_building_again_gives_the_committed_bundles(tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None or not (CLIENT / "node_modules").is_dir():
        pytest.skip("no Node, or its tools are not installed (cd viewer-client && npm ci)")
    subprocess.run([node, "build.mjs", "--out", tmp_path], cwd=CLIENT, check=True)
    for bundle in named_by_the_build():
        built = tmp_path / bundle.relative_to(PACKAGE)
        assert built.read_bytes() == bundle.read_bytes()


def test_the_lock_file_names_no_download_address() -> None:
    lock = json.loads((CLIENT / "package-lock.json").read_text(encoding="utf-8"))
    assert len(lock["packages"]) > 3
    assert [name for name, one in lock["packages"].items() if "resolved" in one] == []
    assert all(one.get("integrity") for name, one in lock["packages"].items() if name)
