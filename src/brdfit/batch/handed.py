"""What every worker is given when it starts, held in memory once.

A process that is started reads what it is given from a pipe, and who starts it waits until it
does: workers would start one after the other. Here they are given an open file without a name,
and map it; the arrays in it are views of the map, so that all workers share them. It is gone
when the last process that holds it ends, however that ends.
"""

from __future__ import annotations

import mmap
import os
import pickle
import tempfile
from multiprocessing import reduction
from typing import Any

__all__ = ["Handed"]

_ALIGNED = 64


class Handed:
    """A value on its way to processes that are started with it; unpickled once in each."""

    def __init__(self, value: object) -> None:
        arrays: list[pickle.PickleBuffer] = []
        head = pickle.dumps(value, protocol=5, buffer_callback=arrays.append)
        self._file = tempfile.TemporaryFile()  # noqa: SIM115 - closed when the last worker stands
        self._places: list[tuple[int, int]] = []
        parts: list[bytes | memoryview] = [head, *(array.raw() for array in arrays)]
        for part in parts:
            start = -(-self._file.tell() // _ALIGNED) * _ALIGNED
            self._file.seek(start)
            self._file.write(part)
            self._places.append((start, len(part)))
        self._file.flush()

    def __enter__(self) -> Handed:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __getstate__(self) -> dict[str, Any]:
        return {"places": self._places, "file": reduction.DupFd(self._file.fileno())}

    def __setstate__(self, state: dict[str, Any]) -> None:
        descriptor = state["file"].detach()
        whole = memoryview(mmap.mmap(descriptor, 0, access=mmap.ACCESS_READ))
        os.close(descriptor)
        head, *arrays = (whole[start : start + size] for start, size in state["places"])
        self.value: Any = pickle.loads(head, buffers=arrays)
        """What was handed over; only in the process that received it."""
