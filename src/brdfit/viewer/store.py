"""What the server holds: items and uploads by id, and the private folder of its files."""

from __future__ import annotations

import itertools
import shutil
import tempfile
import threading
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from brdfit.errors import UsageError
from brdfit.samples import Samples
from brdfit.viewer.item import Item

__all__ = ["Held", "NotThere", "Store"]

_MOST_MADE = 24
"""Refits and uploads that are kept at once; each holds a table of about 20 MB."""


class NotThere(UsageError):
    """There is nothing of this name, or no longer."""


@dataclass(frozen=True, eq=False)
class Held:
    """Measurements that were handed over, to be fitted."""

    id: str
    name: str
    samples: Samples
    source: Path
    warnings: tuple[str, ...] = ()


class Store:
    """Items and uploads by id; a context that removes its folder at the end.

    What was opened at the start stays; of what was made since, the oldest goes when there
    are too many. Safe to use from many threads.
    """

    def __init__(self, keep: int = _MOST_MADE) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="brdfit-view-"))  # for its owner alone
        self._keep = keep
        self._opened: dict[str, Item] = {}
        self._made: OrderedDict[str, Item | Held] = OrderedDict()
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Remove the folder and all that was uploaded."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def next_id(self, letter: str) -> str:
        """Return an id that was never given before."""
        return f"{letter}{next(self._numbers)}"

    def open(self, item: Item) -> None:
        """Keep an item for as long as the server runs."""
        with self._lock:
            self._opened[item.id] = item

    def add(self, made: Item | Held) -> None:
        """Keep what was made while the server runs; the oldest may go for it."""
        with self._lock:
            self._made[made.id] = made
            while len(self._made) > self._keep:
                _, gone = self._made.popitem(last=False)
                if isinstance(gone, Held):
                    self._forget(gone.source)

    def _forget(self, source: Path) -> None:
        # a file of the user's own, opened at the start, is not ours to remove
        if source.is_relative_to(self.folder):
            shutil.rmtree(source.parent, ignore_errors=True)

    @property
    def opened(self) -> list[Item]:
        """What was opened at the start."""
        with self._lock:
            return list(self._opened.values())

    def get(self, id: str) -> Item | Held:
        """Return what has this id; `NotThere` if there is nothing, or no longer."""
        with self._lock:
            found = self._opened.get(id) or self._made.get(id)
            if found is None:
                raise NotThere(
                    f"{id}: there is nothing of this name, or it was let go to make room "
                    f"({self._keep} results are kept). Fit or upload it again."
                )
            if id in self._made:
                self._made.move_to_end(id)
            return found

    def item(self, id: str) -> Item:
        """Return the item of this id; `UsageError` if there is none."""
        found = self.get(id)
        if isinstance(found, Held):
            raise UsageError(f"{found.name}: holds measurements; fit them first.")
        return found
