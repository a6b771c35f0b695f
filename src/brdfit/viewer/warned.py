"""Warnings of readers and writers, caught where many threads work."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from brdfit.errors import BrdfitWarning

__all__ = ["Warned", "heard"]

# The list of warning filters belongs to the whole process: one reader or writer at a time.
_ONE_AT_A_TIME = threading.Lock()


class Warned:
    """What was warned of while a block ran."""

    def __init__(self) -> None:
        self.messages: tuple[str, ...] = ()
        """Each once, in order."""


@contextmanager
def heard() -> Iterator[Warned]:
    """Collect brdfit's warnings while the block runs, instead of showing them."""
    warned = Warned()
    with _ONE_AT_A_TIME, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", BrdfitWarning)
        yield warned
    warned.messages = tuple(dict.fromkeys(str(one.message) for one in caught))
