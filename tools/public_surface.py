"""Describe the public surface of brdfit as text: what callers may rely on.

`tests/golden/public_surface.txt` holds this text; `tools/regenerate_golden.py` writes it.
"""

from __future__ import annotations

import dataclasses
import enum
import inspect
from typing import Any

import brdfit

__all__ = ["describe", "public_objects", "signature_of"]


def public_objects() -> dict[str, Any]:
    """Return every public name and what it is."""
    return {name: getattr(brdfit, name) for name in brdfit.__all__}


def describe() -> str:
    """Return one block of lines for each public name, in order."""
    return "\n".join(line for name, what in public_objects().items() for line in _block(name, what))


def signature_of(function: Any) -> str:
    """Return the parameters and the result of a function as they are written."""
    signature = inspect.signature(function)
    parts, keyword_only = [], False
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not keyword_only:
            parts.append("*")
        keyword_only |= parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_POSITIONAL)
        stars = {parameter.VAR_POSITIONAL: "*", parameter.VAR_KEYWORD: "**"}
        text = stars.get(parameter.kind, "") + parameter.name
        if parameter.annotation is not parameter.empty:
            text += f": {_written(parameter.annotation)}"
        if parameter.default is not parameter.empty:
            text += f" = {_default(parameter.default)}"
        parts.append(text)
    result = signature.return_annotation
    arrow = "" if result is signature.empty else f" -> {_written(result)}"
    return f"({', '.join(parts)}){arrow}"


def _block(name: str, what: Any) -> list[str]:
    if not inspect.isclass(what):
        if callable(what):
            return [f"{name}{signature_of(what)}"]
        return [f"{name}: {type(what).__name__}"]
    bases = ", ".join(base.__name__ for base in what.__bases__ if base is not object)
    lines = [f"class {name}({bases})" if bases else f"class {name}"]
    if dataclasses.is_dataclass(what):
        lines += [f"    {field.name}: {_written(field.type)}" for field in dataclasses.fields(what)]
    if issubclass(what, enum.Enum):
        return lines + [f"    {member.name} = {member.value!r}" for member in what]
    return lines + [line for key in sorted(vars(what)) for line in _member(what, key)]


def _member(owner: type, name: str) -> list[str]:
    raw = inspect.getattr_static(owner, name)
    if name.startswith("_"):
        return []
    if isinstance(raw, staticmethod | classmethod):
        return [f"    {name}{signature_of(raw.__func__)}"]
    if inspect.isfunction(raw):
        return [f"    {name}{signature_of(raw)}"]
    if isinstance(raw, property) or type(raw).__name__ == "cached_property":
        getter = raw.fget if isinstance(raw, property) else raw.func
        return [f"    {name} -> {_written(inspect.signature(getter).return_annotation)}"]
    return []


def _written(annotation: Any) -> str:
    return annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)


def _default(value: Any) -> str:
    return value.__name__ if inspect.isroutine(value) or inspect.isclass(value) else repr(value)
