"""Long products by two threads: what one thread makes of them, and the same bits every time."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.linalg import tall
from brdfit.linalg.tall import forward, weighted_gram

# Few enough for the library, and enough for two threads, with blocks that are not full.
SIZES = [(40, 7), (1037, 391)]


@pytest.fixture(params=SIZES, ids=["few", "many"])
def rows(request, rng):
    return rng.normal(size=request.param)


def test_the_sizes_are_on_either_side_of_what_is_shared_out():
    small, large = (n * d * d < tall._WORTH_IT for n, d in SIZES)
    assert small
    assert not large
    assert SIZES[1][1] % tall._BLOCK
    assert SIZES[1][0] % tall._TOGETHER


def test_a_gram_matrix_is_the_sum_over_rows(rows, rng):
    weights = rng.uniform(0.0, 4.0, len(rows))
    found = weighted_gram(rows, weights)
    assert np.allclose(found, np.einsum("ni,n,nj->ij", rows, weights, rows, optimize=True))
    assert np.array_equal(found, weighted_gram(rows, weights))


def test_a_solution_solves_and_reads_the_lower_triangle_only(rows):
    d = rows.shape[1]
    factor = np.linalg.cholesky(np.eye(d) + rows.T @ rows)
    wild = factor + np.triu(np.full((d, d), 1e9), 1)
    found = forward(wild, rows.T)
    assert found.shape == (d, len(rows))
    assert np.allclose(factor @ found, rows.T, rtol=0.0, atol=1e-12)
    assert np.array_equal(found, forward(wild, rows.T))


def test_what_is_given_is_left_as_it_was(rows):
    factor = np.linalg.cholesky(np.eye(rows.shape[1]) + rows.T @ rows)
    weights = np.ones(len(rows))
    kept = rows.copy(), factor.copy()
    weighted_gram(rows, weights)
    forward(factor, rows.T)
    assert np.array_equal(rows, kept[0])
    assert np.array_equal(factor, kept[1])
