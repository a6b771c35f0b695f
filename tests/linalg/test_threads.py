"""Threads of the linear algebra are limited within a block, and given back after it."""

from __future__ import annotations

import threading

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from brdfit.linalg import one_thread, side_by_side


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


@pytest.mark.parametrize("count", [0, 1, 2, 7])
def test_side_by_side_every_number_is_done_once_in_one_thread_of_linear_algebra(count):
    done, threads = [], set()

    def task(number):
        done.append(number)
        threads.update(blas_threads())

    side_by_side(task, count)
    assert sorted(done) == list(range(count))
    assert threads <= {1}


@pytest.mark.parametrize("wrong", [2, 3])
def test_what_goes_wrong_on_either_side_is_told(wrong):
    def task(number):
        if number == wrong:
            raise ValueError(f"number {number}")

    with pytest.raises(ValueError, match=f"number {wrong}"):
        side_by_side(task, 6)
