"""An import only ever points down.

The floors are those of the design. Units of a floor stand in an order: one may import those
before it; on the floors of siblings none imports another at all.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from source_tree import Module, imports_of, package_modules, parse

FLOORS = [
    ["errors", "arrays", "files", "progress", "display", "tone", "versions"],
    ["geometry", "grid"],
    ["samples", "table", "models", "albedo"],
    ["formats"],
    ["populations", "robust", "linalg", "transform", "metrics", "render", "physics"],
    ["reconstruct"],
    ["batch", "report", "export", "mitsuba", "bench"],
    ["viewer", "cli", "__main__"],
]
FLOOR = {unit: floor for floor, units in enumerate(FLOORS) for unit in units}

SIBLINGS = {3, 4}
FLOOR_0_ONLY = {"linalg", "robust"}  # they know nothing of BRDFs

# The front door re-exports from everywhere; that is what it is for.
FRONT_DOOR = ""


def violations(module: Module) -> Iterator[str]:
    """Yield a sentence for each import that does not point down."""
    if module.name == FRONT_DOOR:
        return
    if module.unit not in FLOOR:
        yield f"{module.path}: {module.unit!r} has no floor; give it one in {__file__}"
        return
    for found in imports_of(module):
        if not (found.target == "brdfit" or found.target.startswith("brdfit.")):
            continue
        target = found.target.removeprefix("brdfit").removeprefix(".")
        unit = target.partition(".")[0]
        if unit not in FLOOR:
            # `import brdfit` and `from brdfit import fit` hide what they lean on
            reason = None if module.unit in FLOORS[-1] else "goes through the front door"
        else:
            reason = _reason(module, unit, target)
        if reason:
            yield f"{module.at(found.line)}: {module.name} imports {found.target}: {reason}"


def _reason(module: Module, unit: str, target: str) -> str | None:
    here, there = FLOOR[module.unit], FLOOR[unit]
    if unit == module.unit:
        return _across_formats(module, target) if unit == "formats" else None
    if there > here:
        return f"floor {there} is above floor {here}"
    if there == here and here in SIBLINGS:
        return "siblings never import each other"
    if there == here and FLOORS[here].index(unit) > FLOORS[here].index(module.unit):
        return f"within floor {here} the order is {FLOORS[here]}"
    if module.unit in FLOOR_0_ONLY and there > 0:
        return "it knows nothing of BRDFs and sees floor 0 only"
    return None


def _across_formats(module: Module, target: str) -> str | None:
    own, other = _format_folder(module.name), _format_folder(target)
    if own and other and own != other:
        return "a format never imports another; what they share is in formats/"
    return None


def _format_folder(name: str) -> str:
    folder = name.split(".")[1] if name.count(".") else ""
    folders = {m.name.split(".")[1] for m in package_modules() if _is_format(m)}
    return folder if folder in folders else ""


def _is_format(module: Module) -> bool:
    return module.unit == "formats" and module.name.count(".") == 1 and module.is_package


def test_every_import_points_down() -> None:
    assert [line for module in package_modules() for line in violations(module)] == []


def test_every_unit_has_a_floor_and_every_folder_of_the_package_is_looked_at() -> None:
    units = {module.unit for module in package_modules()} - {FRONT_DOOR}
    assert units <= set(FLOOR)
    assert {"geometry", "formats", "reconstruct", "cli"} <= units


@pytest.mark.parametrize(
    ("name", "source", "expected"),
    [
        ("grid", "from brdfit.samples import Samples", "floor 2 is above floor 1"),
        ("grid", "def f():\n    from brdfit import samples", "floor 2 is above floor 1"),
        ("samples", "from .table import Table", "within floor 2 the order is"),
        ("render.sphere", "from ..metrics import ciede", "siblings never import each other"),
        ("linalg.solve", "import brdfit.geometry", "sees floor 0 only"),
        ("formats.merl.read", "from brdfit.formats.astm import read", "never imports another"),
        ("formats.text", "from brdfit.populations import population", "floor 4 is above floor 3"),
        ("reconstruct.fit", "from brdfit import Samples", "goes through the front door"),
        ("reconstruct.fit", "import brdfit", "goes through the front door"),
        ("novelty", "", "'novelty' has no floor"),
        (
            "errors",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from brdfit.cli import main",
            "floor 7 is above floor 0",
        ),
    ],
)
def test_a_planted_import_that_does_not_point_down_is_caught(
    name: str, source: str, expected: str
) -> None:
    caught = list(violations(parse(name, source)))
    assert len(caught) == 1
    assert expected in caught[0]


@pytest.mark.parametrize(
    ("name", "source"),
    [
        ("table", "from brdfit.samples import Source"),
        ("formats.merl.read", "from brdfit.formats.text import lines"),
        ("formats.merl.read", "from . import sheet"),
        ("reconstruct.fit", "from brdfit.linalg import solve"),
        ("cli.main", "import brdfit"),
        ("grid", "import numpy as np\nfrom collections import abc"),
    ],
)
def test_an_import_that_points_down_is_let_through(name: str, source: str) -> None:
    assert list(violations(parse(name, source))) == []
