"""Tables as Markdown, made from records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Column", "cell", "table"]


@dataclass(frozen=True)
class Column:
    """A title, and whether the column holds numbers."""

    title: str
    number: bool = False


def cell(*values: float | None, digits: int = 3, bold: bool = False) -> str:
    """Return figures with a slash between, "-" for one that is not known."""
    text = " / ".join("-" if value is None else f"{value:.{digits}f}" for value in values)
    return f"**{text}**" if bold else text


def table(columns: Sequence[Column], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table, numbers to the right, ending with a line feed."""
    head = "| " + " | ".join(column.title for column in columns) + " |"
    rule = "|" + "|".join("---:" if column.number else "---" for column in columns) + "|"
    body = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([head, rule, *body]) + "\n"
