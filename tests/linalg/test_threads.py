"""Threads of the linear algebra are limited within a block, and given back after it."""

from __future__ import annotations

import threading

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from brdfit.linalg import one_thread


def blas_threads():
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def two():
    with threadpool_limits(limits=2, user_api="blas"):
        yield


def test_a_block_has_one_thread_and_what_was_set_comes_back():
    before = blas_threads()
    with one_thread():
        assert blas_threads() == {1}
        with one_thread():
            assert blas_threads() == {1}
        assert blas_threads() == {1}
    assert blas_threads() == before


def test_an_error_gives_the_threads_back_as_well():
    before = blas_threads()

    @one_thread()
    def fails():
        assert blas_threads() == {1}
        raise ValueError("as asked")

    with pytest.raises(ValueError, match="as asked"):
        fails()
    assert blas_threads() == before


def test_a_block_that_ends_does_not_lift_the_limit_of_another_thread():
    entered, leave = threading.Event(), threading.Event()

    def other():
        with one_thread():
            entered.set()
            leave.wait(10.0)

    thread = threading.Thread(target=other)
    with one_thread():
        thread.start()
        assert entered.wait(10.0)
    assert blas_threads() == {1}
    leave.set()
    thread.join()
