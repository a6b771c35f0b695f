"""Products of long matrices with few columns are products."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.linalg import thin_product
from brdfit.linalg.thin import plain_thin_product


@pytest.mark.parametrize("shape", [(0, 5, 3), (7, 5, 3), (9000, 41, 3), (300, 600, 900)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_it_is_the_product_in_the_precision_of_its_factors(shape, dtype):
    n, k, c = shape
    rng = np.random.default_rng(1)
    rows, columns = rng.normal(size=(n, k)).astype(dtype), rng.normal(size=(k, c)).astype(dtype)
    found = thin_product(rows, columns)
    assert found.dtype == dtype
    assert np.allclose(found, rows @ columns, atol=1e-3 if dtype == np.float32 else 1e-10)


@pytest.mark.parametrize("columns", [1, 3, 8, 9])
@pytest.mark.parametrize("shape", [(1, 1), (6, 31), (4099, 171)])
def test_compiled_or_not_it_is_one_product(shape, columns):
    rng = np.random.default_rng(2)
    rows = rng.normal(size=shape).astype(np.float32)
    factors = rng.normal(size=(shape[1], columns)).astype(np.float32)
    found, exact = thin_product(rows, factors), rows.astype(np.float64) @ factors
    assert found.dtype == np.float32
    for one in (found, plain_thin_product(rows, factors)):
        assert np.abs(one - exact).max() < 2e-6 * shape[1]
    assert np.array_equal(thin_product(np.asfortranarray(rows), factors), found)
