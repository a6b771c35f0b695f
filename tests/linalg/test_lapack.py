"""Factors and inverses by LAPACK: without the interpreter's lock, and with it the same."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from brdfit.linalg import lapack


@pytest.fixture
def matrix():
    rows = np.random.default_rng(4).normal(size=(60, 60))
    return rows @ rows.T + 60.0 * np.eye(60)


@pytest.mark.parametrize("wrapped", [False, True])
def test_the_lower_triangles_are_factor_and_inverse(matrix, wrapped, monkeypatch):
    if wrapped:
        monkeypatch.setattr(lapack, "_routine", lambda name: None)
    factor, inverse = lapack.factor_and_inverse(matrix.copy())
    lower = np.tril(factor)
    np.testing.assert_allclose(lower @ lower.T, matrix, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(np.tril(inverse), np.tril(np.linalg.inv(matrix)), atol=1e-12)


def test_how_the_matrix_lies_in_memory_changes_nothing(matrix):
    factor, inverse = lapack.factor_and_inverse(matrix.copy())
    other, another = lapack.factor_and_inverse(np.asfortranarray(matrix))
    np.testing.assert_array_equal(np.tril(factor), np.tril(other))
    np.testing.assert_array_equal(np.tril(inverse), np.tril(another))


@pytest.mark.parametrize("wrapped", [False, True])
def test_what_is_not_positive_definite_is_refused(matrix, wrapped, monkeypatch):
    if wrapped:
        monkeypatch.setattr(lapack, "_routine", lambda name: None)
    matrix[7, 7] = -1.0
    with pytest.raises(np.linalg.LinAlgError, match="minor 8"):
        lapack.factor_and_inverse(matrix)


def longest_pause_of_another(work):
    """Return the longest pause of a thread that only ticks, as a share of the time of `work`."""
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(1e-4)

    other = threading.Thread(target=tick)
    other.start()
    try:
        begin = time.perf_counter()
        work()
        end = time.perf_counter()
    finally:
        done.set()
        other.join()
    within = [begin, *(at for at in ticks if begin < at < end), end]
    return float(np.diff(within).max()) / (end - begin)


def test_another_thread_goes_on_meanwhile(monkeypatch):
    def work():
        lapack.factor_and_inverse(np.eye(1500) + 1e-3)

    without = longest_pause_of_another(work)
    monkeypatch.setattr(lapack, "_routine", lambda name: None)
    assert without < 0.5 * longest_pause_of_another(work)
