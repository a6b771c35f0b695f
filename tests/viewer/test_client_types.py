"""The types of the page are those of the server."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import pytest

import client_types


def test_the_committed_types_are_made_from_the_messages() -> None:
    assert client_types.FILE.read_text(encoding="utf-8") == client_types.render()


@dataclass(frozen=True)
class _Inner:
    """Something small."""

    size: int


@dataclass(frozen=True)
class _Outer:
    """One of each."""

    number: float | None
    """A number, or nothing."""
    word: Literal["a", "b"]
    inner: list[_Inner]
    maybe: list[float | None]
    table: dict[str, bool]
    more: str = ""
    others: list[int] = field(default_factory=list)


def test_every_kind_of_field_has_its_counterpart() -> None:
    assert client_types.interface(_Outer) == (
        "/** One of each. */\n"
        "export interface _Outer {\n"
        "  /** A number, or nothing. */\n"
        "  number: number | null;\n"
        '  word: "a" | "b";\n'
        "  inner: _Inner[];\n"
        "  maybe: (number | null)[];\n"
        "  table: Record<string, boolean>;\n"
        "  more?: string;\n"
        "  others?: number[];\n"
        "}\n"
    )


def test_a_type_without_a_counterpart_is_refused() -> None:
    with pytest.raises(TypeError, match="no counterpart"):
        client_types.typescript(bytes)
