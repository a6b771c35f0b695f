"""Inverses of many small positive definite matrices: by halves, and compiled."""

from __future__ import annotations

import numpy as np
import pytest
from array_api_compat import numpy as xp

from brdfit.linalg import inverse_by_halves, inverses, sweep_if_compiled


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


@pytest.mark.parametrize("size", [1, 13, 49])
def test_the_compiled_sweep_is_what_the_halves_say(rng, size):
    sweep = sweep_if_compiled()
    if sweep is None:
        pytest.skip("numba is not installed: pip install 'brdfit[fast]'")
    a = definite(rng, 40, size)
    before = a.copy()
    assert np.allclose(sweep(a), inverse_by_halves(xp, a), rtol=1e-9, atol=1e-14)
    assert np.array_equal(a, before)


def test_few_and_many_are_the_same(rng):
    a = definite(rng, 64, 21).reshape(32, 2, 21, 21)
    assert np.allclose(inverses(xp, a)[:3], inverses(xp, a[:3]), rtol=1e-10, atol=1e-14)


def test_badly_scaled_but_definite_matrices_are_inverted(rng):
    scale = np.exp(rng.uniform(-6.0, 6.0, 41))
    a = definite(rng, 40, 41) * scale[:, None] * scale
    for found in (inverses(xp, a), inverse_by_halves(xp, a)):
        assert np.allclose(found @ a, np.eye(41), atol=1e-6)
