"""How an object shows itself in a notebook, without knowing who draws it.

The frozen data stand on low floors, pictures are made on high ones. A class that inherits
`Shown` has the method that notebooks ask for; the front door says who answers.
"""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Draw", "Shown", "draw_with"]

Draw = Callable[[object], str]
"""`draw(what)`: HTML that shows `what`."""

_drawn_by: list[Draw] = []


def draw_with(draw: Draw) -> None:
    """Let `draw` answer for everything that is `Shown`, in place of who did before."""
    _drawn_by[:] = [draw]


class Shown:
    """Shows itself as a small picture with its key figures, where HTML can be shown."""

    def _repr_html_(self) -> str | None:
        """Return HTML for a notebook; None, which means the usual text, if nobody draws."""
        return _drawn_by[0](self) if _drawn_by else None
