"""One thread of linear algebra for the length of a block, and two of other work.

The products of a fit are short and many. A threaded BLAS makes its threads wait for one another
at the end of each, spinning; where other processes want the cores too, most of the time goes
into that: a fit of 2.4 s took 16 to 24 s with two threads on two busy cores.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

__all__ = ["one_thread", "side_by_side"]


class _Limit:
    """Held from the first block that is entered to the last that is left, in any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0
        self._limits: Any = None
        self._controller: Any = None
        self._modules = 0

    def enter(self) -> None:
        from threadpoolctl import ThreadpoolController

        with self._lock:
            self._inside += 1
            if self._inside == 1:
                # To look for the libraries takes milliseconds; new ones come with modules.
                if len(sys.modules) != self._modules:
                    self._controller, self._modules = ThreadpoolController(), len(sys.modules)
                self._limits = self._controller.limit(limits=1, user_api="blas")

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self._limits.restore_original_limits()


_LIMIT = _Limit()


@contextmanager
def one_thread() -> Iterator[None]:
    """Hold the linear algebra of this process to one thread; also a decorator.

    What was set before comes back when the last block ends, however it ends. (OpenBLAS takes
    a larger number only from the thread that set the smaller one: where blocks of several
    threads overlap and another ends last, the process keeps one.)
    """
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


def side_by_side(task: Callable[[int], None], count: int) -> None:
    """Call `task` with every number below `count`: the even ones here, the odd ones beside.

    numpy lets go of the interpreter in its loops: two threads keep two cores busy. Each number
    is one task's alone: what comes out does not depend on who does it.
    """

    def every_second(first: int) -> None:
        for number in range(first, count, 2):
            task(number)

    with one_thread(), ThreadPoolExecutor(1) as pool:
        beside = pool.submit(every_second, 1)
        every_second(0)
        beside.result()
