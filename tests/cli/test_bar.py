from __future__ import annotations

import io
import time

import pytest

from brdfit.cli.bar import Bar
from brdfit.cli.console import Console


class _Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


class _Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_quick_work_shows_nothing() -> None:
    stream, clock = io.StringIO(), _Clock()
    bar = Bar(stream, delay=60.0, clock=clock)
    for done in range(4):
        bar("quick", done, 3)
        clock.now += 0.1
    bar.close()
    assert stream.getvalue() == ""


def test_long_work_writes_a_line_now_and_then_where_there_is_no_terminal() -> None:
    stream, clock = io.StringIO(), _Clock()
    bar = Bar(stream, delay=60.0, clock=clock)
    for done in range(101):
        bar("long", done, 100)
        clock.now += 1.0
    bar.close()
    lines = stream.getvalue().splitlines()
    assert lines[0] == "brdfit: long: 60 % (60 s)"
    assert 5 <= len(lines) <= 10


def test_work_that_counts_something_says_how_many_a_second_and_how_long_it_takes_yet() -> None:
    stream, clock = io.StringIO(), _Clock()
    bar = Bar(stream, delay=60.0, clock=clock, unit="items")
    for second in range(0, 101, 10):  # 4,000 were done before: they are no work of this run
        bar("items", 4_000 + 50 * second, 10_000)
        clock.now += 10.0
    bar("another", 1, 2)
    bar.close()
    lines = stream.getvalue().splitlines()
    assert lines[0] == "brdfit: items: 70 % (60 s, 50 a second, 60 s left)"
    assert lines[-1] == "brdfit: another: 50 % (110 s)"


def test_work_that_does_not_call_again_is_shown_all_the_same() -> None:
    stream = io.StringIO()
    bar = Bar(stream, delay=0.05)
    bar("silent work", 0, 10)
    limit = time.monotonic() + 10.0
    while not stream.getvalue() and time.monotonic() < limit:
        time.sleep(0.01)
    bar.close()
    assert "silent work: 0 %" in stream.getvalue()


def test_on_a_terminal_a_bar_is_drawn_and_taken_away() -> None:
    stream, clock = _Terminal(), _Clock()
    bar = Bar(stream, delay=60.0, clock=clock)
    bar("drawn", 0, 10)
    clock.now += 61.0
    bar("drawn", 5, 10)
    bar.close()
    assert "drawn" in stream.getvalue()
    assert "50 %" in stream.getvalue()


def test_a_warning_is_named_once_and_kept() -> None:
    err = io.StringIO()
    console = Console(io.StringIO(), err)
    console.warn("FitWarning", "look")
    console.warn("FitWarning", "look")
    assert err.getvalue() == "brdfit: warning: FitWarning: look\n"
    assert console.warnings == ["FitWarning: look"]


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_without_unicode_still_gets_the_line(encoding: str) -> None:
    raw = io.BytesIO()
    console = Console(io.TextIOWrapper(raw, encoding=encoding), io.StringIO())
    console.say("Δ of f_r")
    assert b"of f_r" in raw.getvalue()
