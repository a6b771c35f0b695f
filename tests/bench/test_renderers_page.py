"""What docs/renderers.md says is what was recorded."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("key", "form"),
    [
        ("log_difference_80", "| {:.3f} |"),
        ("log_difference_87", "| {:.3f} |"),
        ("weights_off_brightest", "| {:.1%} |"),
        ("weights_off_channel", "| {:.1%} |"),
        ("measured_and_plugin", "| {:.2f} |"),
        ("preview_and_plugin", "| {:.2f} |"),
        ("noise", "| {:.2f} |"),
        ("time_ratio", "| {:.2f} |"),
    ],
)
def test_the_worst_file_of_each_question_is_quoted(key: str, form: str) -> None:
    path = ROOT / "benchmarks" / "results" / "renderers.json"
    records = json.loads(path.read_text(encoding="utf-8"))["records"]
    page = (ROOT / "docs" / "renderers.md").read_text(encoding="utf-8")
    assert form.format(max(record[key] for record in records.values())) in page
    assert f"on {len(records)} files" in page
