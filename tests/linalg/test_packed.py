"""Symmetric matrices as their lower triangles."""

from __future__ import annotations

import numpy as np
import pytest
from array_api_compat import numpy as xp

from brdfit.linalg import Triangle


@pytest.mark.parametrize("size", [1, 2, 7])
def test_what_is_packed_is_unpacked(rng, size):
    whole = rng.normal(size=(3, 2, size, size))
    whole += whole.transpose(0, 1, 3, 2)
    triangle = Triangle.of(size)
    packed = triangle.pack(xp, whole)
    assert packed.shape == (3, 2, size * (size + 1) // 2)
    assert np.array_equal(packed[1, 1], whole[1, 1][np.tril_indices(size)])
    assert np.array_equal(triangle.unpack(xp, packed), whole)


def test_products_of_packed_are_those_of_the_whole(rng):
    vectors, weights = rng.normal(size=(9, 5)), rng.random(9)
    triangle = Triangle.of(5)
    squares = triangle.squares(xp, vectors)
    gram = vectors.T @ (weights[:, None] * vectors)
    assert np.allclose(triangle.unpack(xp, weights @ squares), gram)
    forms = np.einsum("ni,ij,nj->n", vectors, gram, vectors)
    assert np.allclose(triangle.doubled(xp, squares) @ triangle.pack(xp, gram), forms)
