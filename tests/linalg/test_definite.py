"""Inverses of many small positive definite matrices: by halves, compiled, packed."""

from __future__ import annotations

import numpy as np
import pytest
from array_api_compat import numpy as xp

from brdfit.linalg import Triangle, inverse_by_halves, solved, sweep_if_compiled


def definite(rng, count, size):
    a = rng.normal(size=(count, size, 2 * size))
    return a @ a.transpose(0, 2, 1) + np.eye(size)


@pytest.mark.parametrize("size", [1, 2, 16, 17, 33, 49, 81])
def test_by_halves_it_is_the_inverse(rng, size):
    a = definite(rng, 5, size)
    found = inverse_by_halves(xp, a)
    assert np.allclose(found @ a, np.eye(size), atol=1e-10)
    assert np.allclose(found, found.transpose(0, 2, 1), atol=1e-14)
    stacked = inverse_by_halves(xp, a.reshape(1, 5, size, size))
    assert np.allclose(stacked[0], found, rtol=1e-13)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("size", [1, 4, 13, 41, 49])
@pytest.mark.parametrize("vectors", [1, 3])
def test_the_compiled_sweep_is_what_the_halves_say(rng, size, vectors, packed):
    sweep = sweep_if_compiled()
    if sweep is None:
        pytest.skip("numba is not installed: pip install 'brdfit[fast]'")
    a, right = definite(rng, 40, size), rng.normal(size=(40, vectors, size))
    triangle = Triangle.of(size)
    given = triangle.pack(xp, a) if packed else a
    before = given.copy()
    inverse, solution = solved(xp, given, right, packed)
    whole = triangle.unpack(xp, inverse) if packed else inverse
    expected = inverse_by_halves(xp, a)
    assert np.allclose(whole, expected, rtol=1e-9, atol=1e-14)
    assert np.allclose(solution, right @ expected, rtol=1e-9, atol=1e-13)
    assert np.array_equal(given, before)


@pytest.mark.parametrize("packed", [False, True])
def test_few_and_many_are_the_same(rng, packed):
    a, right = definite(rng, 64, 21).reshape(32, 2, 21, 21), rng.normal(size=(32, 2, 3, 21))
    given = Triangle.of(21).pack(xp, a) if packed else a
    many, few = solved(xp, given, right, packed), solved(xp, given[:1], right[:1], packed)
    assert [m.shape for m in many] == [given.shape, right.shape]
    for one, other in zip(many, few, strict=True):
        assert np.allclose(one[:1], other, rtol=1e-10, atol=1e-14)


def test_badly_scaled_but_definite_matrices_are_inverted(rng):
    scale = np.exp(rng.uniform(-6.0, 6.0, 41))
    a = definite(rng, 40, 41) * scale[:, None] * scale
    for found in (solved(xp, a, a[:, :1])[0], inverse_by_halves(xp, a)):
        assert np.allclose(found @ a, np.eye(41), atol=1e-6)


@pytest.mark.parametrize("packed", [False, True])
def test_one_matrix_serves_the_vectors_of_many(rng, packed):
    a, right = definite(rng, 2, 13).reshape(2, 1, 13, 13), rng.normal(size=(2, 31, 1, 13))
    given = Triangle.of(13).pack(xp, a) if packed else a
    inverse, solution = solved(xp, given, right, packed)
    assert inverse.shape == given.shape
    assert np.allclose(solution @ a, right, atol=1e-9)
