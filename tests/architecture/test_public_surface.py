"""The public surface is a list, and changes only on purpose."""

from __future__ import annotations

import ast
import difflib
import inspect
from pathlib import Path
from typing import Any

import pytest

import brdfit

import public_surface
from source_tree import package_modules

GOLDEN = Path(__file__).parents[1] / "golden" / "public_surface.txt"
FRONT_DOOR = next(module for module in package_modules() if module.name == "")
OBJECTS = public_surface.public_objects()

# (owner, function) of every public function, method and property
CALLABLES = [
    pytest.param(function, id=name)
    for name, what in OBJECTS.items()
    for name, function in (
        [(name, what)]
        if inspect.isfunction(what)
        else [
            (f"{name}.{key}", getattr(member, "fget", None) or getattr(member, "func", member))
            for key, member in (vars(what).items() if inspect.isclass(what) else ())
            if not key.startswith("_")
            and (
                inspect.isfunction(member)
                or isinstance(member, property)
                or type(member).__name__ == "cached_property"
            )
        ]
    )
]


def test_the_names_are_sorted_and_each_once() -> None:
    assert list(brdfit.__all__) == sorted(set(brdfit.__all__))


@pytest.mark.parametrize("name", brdfit.__all__)
def test_every_public_name_can_be_used(name: str) -> None:
    assert getattr(brdfit, name) is not None
    assert name in dir(brdfit)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'brdfit' has no attribute 'fitt'"):
        _ = brdfit.fitt


def test_what_type_checkers_see_is_what_is_imported() -> None:
    block = next(node for node in FRONT_DOOR.tree.body if isinstance(node, ast.If))
    seen = {
        alias.asname or alias.name: str(node.module)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == {name: f"brdfit.{home}" for name, home in brdfit._HOME.items()}


def test_the_surface_is_the_one_that_was_agreed_on() -> None:
    agreed = GOLDEN.read_text(encoding="utf-8").splitlines()
    found = public_surface.describe().splitlines()
    difference = "\n".join(difflib.unified_diff(agreed, found, "agreed", "found", n=0, lineterm=""))
    assert found == agreed, (
        f"the public surface changed:\n{difference}\n"
        f"If that is meant: python tools/regenerate_golden.py, and a line in CHANGELOG.md."
    )


@pytest.mark.parametrize("name", brdfit.__all__)
def test_every_public_name_is_documented(name: str) -> None:
    if inspect.isclass(OBJECTS[name]) or callable(OBJECTS[name]):
        own = OBJECTS[name].__doc__
        assert own, f"brdfit.{name} has no docstring"
        # what a dataclass writes for itself is its signature
        assert not own.startswith(f"{name}(")


@pytest.mark.parametrize("function", CALLABLES)
def test_every_public_function_is_documented(function: Any) -> None:
    assert inspect.getdoc(function)


@pytest.mark.parametrize("function", CALLABLES)
def test_every_public_function_is_fully_annotated(function: Any) -> None:
    signature = inspect.signature(function)
    bare = [
        name
        for name, parameter in signature.parameters.items()
        if parameter.annotation is parameter.empty and name not in ("self", "cls")
    ]
    assert bare == []
    assert signature.return_annotation is not signature.empty


def test_the_description_tells_signatures_apart() -> None:
    def one(a: int, *, b: str = "x") -> float: ...
    def two(a: int, *, b: str = "y") -> float: ...

    assert public_surface.signature_of(one) == "(a: int, *, b: str = 'x') -> float"
    assert public_surface.signature_of(one) != public_surface.signature_of(two)
