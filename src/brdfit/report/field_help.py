"""The string under each field of a dataclass: its help, on the command line and on the page."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import itertools
import textwrap
import typing

__all__ = ["field_help"]


def field_help(settings: type) -> dict[str, str]:
    """Return the string under each field of a dataclass, inherited fields included."""
    texts: dict[str, str] = {}
    for cls in reversed(settings.__mro__):
        if dataclasses.is_dataclass(cls):
            texts.update(_strings_under_fields(cls))
    return texts


def _strings_under_fields(cls: type) -> dict[str, str]:
    try:
        source = textwrap.dedent(inspect.getsource(cls))
    except (OSError, TypeError):
        # Without its source a class has no strings under its fields.
        return {}
    body = typing.cast(ast.ClassDef, ast.parse(source).body[0]).body
    texts = {}
    for statement, after in itertools.pairwise(body):
        if (
            isinstance(statement, ast.AnnAssign)
            and isinstance(statement.target, ast.Name)
            and isinstance(after, ast.Expr)
            and isinstance(after.value, ast.Constant)
            and isinstance(after.value.value, str)
        ):
            texts[statement.target.id] = inspect.cleandoc(after.value.value)
    return texts
