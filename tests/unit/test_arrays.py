"""Shape checks say what was found; frozen arrays stay as they are."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.arrays import as_columns, as_directions, dot, frozen, normalize, safe_arccos
from brdfit.errors import UsageError


def test_dot_sums_over_the_last_axis() -> None:
    a = np.arange(6.0).reshape(2, 3)
    assert dot(a, a).tolist() == [5.0, 50.0]


def test_normalize_makes_unit_vectors_and_leaves_null_ones() -> None:
    out = normalize(np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 4.0]]))
    np.testing.assert_allclose(out, [[0.0, 0.0, 0.0], [0.6, 0.0, 0.8]])


def test_safe_arccos_takes_values_rounded_past_one() -> None:
    np.testing.assert_array_equal(safe_arccos(np.array([1 + 1e-15, -1 - 1e-15])), [0.0, np.pi])


def test_a_frozen_array_is_a_copy_that_cannot_be_written() -> None:
    original = np.zeros(3)
    copy = frozen(original)
    original[0] = 1.0
    assert copy[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        copy[0] = 2.0


def test_one_direction_becomes_a_row() -> None:
    assert as_directions("wi", [0, 0, 1]).shape == (1, 3)


@pytest.mark.parametrize("shape", [(2,), (3, 2), (1, 3, 3), ()])
def test_a_wrong_shape_of_directions_is_named(shape: tuple[int, ...]) -> None:
    with pytest.raises(UsageError) as raised:
        as_directions("wo", np.zeros(shape))
    assert str(raised.value).startswith("wo: found an array of shape " + str(shape))


def test_one_value_a_row_is_one_channel() -> None:
    assert as_columns("value", [1.0, 2.0], 2).shape == (2, 1)
    assert as_columns("value", [], 0).shape == (0, 1)


@pytest.mark.parametrize("shape", [(3,), (2, 0), (3, 2), (2, 1, 1)])
def test_a_wrong_shape_of_columns_is_named(shape: tuple[int, ...]) -> None:
    with pytest.raises(UsageError, match=r"sigma: found .* expected \(2, channels\)") as raised:
        as_columns("sigma", np.zeros(shape), 2)
    assert str(shape) in str(raised.value)
