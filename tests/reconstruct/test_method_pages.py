"""What the pages on the methods say is what the code does."""

from __future__ import annotations

import dataclasses
import json
import re
from collections import defaultdict

import numpy as np
import pytest

from brdfit.reconstruct import METHODS, Outcome

from source_tree import ROOT

METHOD = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")
CHOOSE = (ROOT / "docs" / "how-to-choose.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(METHODS))
def test_the_page_lists_every_setting_with_its_default(name):
    kind = METHODS[name]
    section = re.split(r"^## ", METHOD, flags=re.MULTILINE)
    (own,) = [text for text in section if text.startswith(f"`{kind.__name__}`")]
    assert f"--method {name}" in own
    listed = re.findall(r"^\| `(\w+)` \| (\S+) \|", own, re.MULTILINE)
    fields = dataclasses.fields(kind)
    assert listed == [(field.name, str(field.default)) for field in fields]


def test_the_pages_know_every_method_and_outcome():
    for name in METHODS:
        assert f"`{name}`" in CHOOSE
    for outcome in Outcome:
        assert f"`{outcome.value}`" in METHOD


@pytest.mark.parametrize(("place", "condition"), [(0, "share"), (1, "1000:factor")])
def test_the_orders_on_real_files_are_those_of_the_recorded_run(place, condition):
    order = re.findall(r"^    ([\w:]+(?:, [\w:]+){4,})$", CHOOSE, re.MULTILINE)[place]
    means = defaultdict(list)
    recorded = json.loads((ROOT / "benchmarks/results/holdout.json").read_text(encoding="utf-8"))
    for record in recorded["records"]:
        if record["condition"] == condition:
            means[record["method"]].append(record["mean"])
    assert order.split(", ") == sorted(means, key=lambda method: np.mean(means[method]))
