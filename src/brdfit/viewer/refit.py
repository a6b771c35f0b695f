"""What a request to fit means: which samples, which method, and what it leans on."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from typing import Any

import numpy as np

from brdfit.errors import BrdfitError, UsageError
from brdfit.populations import population
from brdfit.reconstruct import METHODS
from brdfit.reconstruct.result import Method
from brdfit.report.field_help import field_help
from brdfit.samples import Flag, Samples
from brdfit.viewer.item import Item
from brdfit.viewer.messages import FitRequest, MethodInfo, Setting

__all__ = ["method_infos", "method_of_record", "requested_method", "with_rejected"]

_POPULATION = "population"


def with_rejected(samples: Samples, request: FitRequest) -> Samples:
    """Return the samples with those of the request switched off and on."""
    bits = np.array(samples.bits)
    for index in (*request.rejected, *request.accepted):
        if not 0 <= index < len(samples):
            raise UsageError(f"sample: found {index} but there are 0 to {len(samples) - 1}.")
    bits[request.rejected] |= int(Flag.REJECTED)
    bits[request.accepted] &= ~int(Flag.REJECTED)
    return dataclasses.replace(samples, flags=bits)


def requested_method(request: FitRequest, item: Item | None) -> tuple[Method, list[str]]:
    """Return the method of a request, and what has to be said about it.

    What the request leaves open is as it was in `item`, else the default. Raises
    `UsageError` for a method, a setting or a population that there is not.
    """
    notes: list[str] = []
    method = None if item is None else _method_of(item, notes)
    name = request.method or (next(iter(METHODS)) if method is None else method.name)
    if name not in METHODS:
        raise UsageError(f"method: found {name!r} but there are {', '.join(METHODS)}.")
    if method is None or method.name != name:
        # another method takes over the population only
        leaning = {_POPULATION: getattr(method, _POPULATION)} if _leans(method) else {}
        kind = METHODS[name]
        method = kind(**(leaning if _leans(kind) else {}))
    changes: dict[str, Any] = {}
    for key, value in request.settings.items():
        changes[key] = _setting(type(method), key, value)
    if request.population and _leans(method):
        changes[_POPULATION] = request.population
    made: Method = dataclasses.replace(method, **changes)  # type: ignore[type-var]
    return made, notes


def _leans(method: object) -> bool:
    if method is None or not dataclasses.is_dataclass(method):
        return False
    return any(item.name == _POPULATION for item in dataclasses.fields(method))


def _method_of(item: Item, notes: list[str]) -> Method | None:
    if item.result is not None:
        return item.result.method
    return method_of_record(item.record, notes)


def method_of_record(record: Mapping[str, Any], notes: list[str]) -> Method | None:
    """Return the method that a record names, as far as it can be told; else say so in `notes`."""
    stated = dict(record.get("method") or {})
    kind = METHODS.get(str(stated.pop("name", "")))
    if kind is None:
        return None
    known = {item.name for item in dataclasses.fields(kind)}
    settings = {key: value for key, value in stated.items() if key in known - {_POPULATION}}
    if _leans(kind):
        settings[_POPULATION] = _population_of(record, notes)
    try:
        method: Method = kind(**settings)
    except (BrdfitError, TypeError) as error:
        notes.append(f"the settings of the record could not be used ({error}): these are defaults")
        method = kind()
    return method


def _population_of(record: Mapping[str, Any], notes: list[str]) -> str:
    leaned = record.get(_POPULATION) or {}
    name = str(leaned.get("name", "published"))
    try:
        same = population(name).fingerprint == leaned.get("fingerprint")
    except BrdfitError:
        notes.append(f"the population {name!r} is not at hand: this leans on 'published'")
        return "published"
    if not same:
        notes.append(
            f"the fit in the files leaned on a part of {name!r} ({leaned.get('members')} members); "
            f"this leans on the whole of it"
        )
    return name


def method_infos() -> list[MethodInfo]:
    """Return every method with its settings, the default first."""
    return [_info(name, kind) for name, kind in METHODS.items()]


def _info(name: str, kind: type) -> MethodInfo:
    texts, hints = field_help(kind), typing.get_type_hints(kind)
    settings = []
    for item in dataclasses.fields(kind):
        form = _form(hints[item.name])
        if item.name == _POPULATION or form is None:
            continue
        default = None if item.default is dataclasses.MISSING else item.default
        kind_of_field, choices = form
        text = " ".join(texts.get(item.name, "").split("\n\n")[0].split())
        settings.append(Setting(item.name, text, kind_of_field, default, choices))  # type: ignore[arg-type]
    title = (kind.__doc__ or name).strip().splitlines()[0]
    return MethodInfo(name, title, settings, _leans(kind))


def _form(hint: Any) -> tuple[str, list[str]] | None:
    """Return how a form asks for a value of this type, or None if it cannot."""
    inner = [one for one in typing.get_args(hint) if one is not type(None)]
    if typing.get_origin(hint) is typing.Literal:
        return "choice", [str(one) for one in inner]
    if inner and len(inner) == 1:
        return _form(inner[0])
    plain = {bool: "flag", int: "integer", float: "number", str: "word"}
    return (plain[hint], []) if hint in plain else None


def _setting(kind: type, name: str, value: float | bool | str | None) -> Any:
    hints = typing.get_type_hints(kind)
    known = {item.name for item in dataclasses.fields(kind)} - {_POPULATION}
    if name not in known:
        raise UsageError(
            f"setting: found {name!r} but {kind.__name__} has {', '.join(sorted(known))}."
        )
    form = _form(hints[name])
    if form is not None and form[0] == "integer" and isinstance(value, float):
        return int(value)
    return value
