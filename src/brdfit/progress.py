"""How long work tells that it goes on, without knowing who listens.

The core never prints. It calls a `Progress` with a label and two counts; the command
line draws a bar, a notebook may do something else, `silent` does nothing.
"""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "silent"]

Progress = Callable[[str, int, int], None]
"""`progress(label, done, total)`: called with done = 0 first and done = total last.

A listener may raise (KeyboardInterrupt, say) to stop the work: nothing half-written stays.
"""


def silent(label: str, done: int, total: int) -> None:
    """Ignore progress."""
