"""Several files that appear together or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path

from brdfit.errors import UsageError
from brdfit.files import atomic_path

__all__ = ["write_set"]


def write_set(writers: Mapping[Path, Callable[[Path], object]]) -> None:
    """Call every writer with a path aside; rename all of them once all have succeeded.

    If a writer raises, or the work is interrupted, no target is touched and nothing is left
    beside them. The first target is renamed last: where it exists, the others do.
    """
    for target in writers:
        if target.is_dir():
            raise UsageError(f"{target}: found a folder but expected the name of a file.")
    with ExitStack() as stack:
        # Leaving the stack renames in the opposite order, nothing but renames in between.
        aside = {target: stack.enter_context(atomic_path(target)) for target in writers}
        for target, write in writers.items():
            write(aside[target])
