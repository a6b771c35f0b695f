"""No committed text names a folder of somebody's machine, or the host of a package registry."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from source_tree import ROOT, tracked_files

# A path counts where it starts: not within a URL, a relative path or a fraction.
MACHINE_PATH = re.compile(
    r"(?<![\w.:/~}\])-])/(?:home|root|tmp|work|Users|mnt|private|var/folders)/[\w.]"
    r"|\b[A-Z]:\\(?:Users|Temp)\\"
)
REGISTRY = re.compile(
    r"(?:pypi|pythonhosted|npmjs|anaconda)\.(?:org|com)|://[\w.]*(?:artifactory|nexus)"
)

BINARY = {".npz", ".png", ".jpg", ".exr", ".binary", ".parquet", ".zip", ".h5", ".xls", ".gz"}


def complaints(text: str) -> list[str]:
    """Return the lines that name a machine or a registry."""
    return [
        f"{number}: {line.strip()[:120]}"
        for number, line in enumerate(text.splitlines(), 1)
        if MACHINE_PATH.search(line) or REGISTRY.search(line)
    ]


def test_no_committed_text_names_a_machine() -> None:
    files = [path for path in tracked_files() if path.suffix not in BINARY]
    assert len(files) > 60
    found = {
        str(path.relative_to(ROOT)): lines
        for path in files
        if path != Path(__file__).resolve()
        and (lines := complaints(path.read_text(encoding="utf-8", errors="replace")))
    }
    assert found == {}


@pytest.mark.parametrize(
    "text",
    [
        "see /home/ann/brdf.binary",
        'open("/tmp/x.csv")',
        "`/Users/bo/data`",
        r"C:\Users\cy\brdf",
        "index-url = https://pypi.org/simple",
    ],
)
def test_a_planted_machine_is_caught(text: str) -> None:
    assert complaints(text)


@pytest.mark.parametrize(
    "text",
    [
        "https://example.org/home/page",
        "../shared/data, docs/home/index.md",
        "1/root/2",
        "/etc/ssl, /usr/bin/env bash",
        "src/tmp/x",
        "wo/work/wi",
    ],
)
def test_a_harmless_text_is_let_through(text: str) -> None:
    assert complaints(text) == []
