"""Products of long matrices with few columns are products."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.linalg import thin_product


@pytest.mark.parametrize("shape", [(0, 5, 3), (7, 5, 3), (9000, 41, 3), (300, 600, 900)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_it_is_the_product_in_the_precision_of_its_factors(shape, dtype):
    n, k, c = shape
    rng = np.random.default_rng(1)
    rows, columns = rng.normal(size=(n, k)).astype(dtype), rng.normal(size=(k, c)).astype(dtype)
    found = thin_product(rows, columns)
    assert found.dtype == dtype
    assert np.allclose(found, rows @ columns, atol=1e-3 if dtype == np.float32 else 1e-10)
