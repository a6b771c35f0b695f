"""Encodings of BRDF values: they are undone by decoding, and follow scale as they say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brdfit.errors import UsageError
from brdfit.transform import ERROR_METRICS, error_metric

NAMES = st.sampled_from(sorted(ERROR_METRICS))
LOGS = st.lists(st.floats(-11.0, 11.0), min_size=1, max_size=20).map(np.array)


@given(NAMES, LOGS)
def test_decoding_undoes_encoding(name, log_value):
    metric = error_metric(name)
    assert np.allclose(metric.decode(metric.encode(log_value)), log_value, atol=1e-9)


@given(NAMES, LOGS)
def test_encoding_keeps_the_order(name, log_value):
    encoded = error_metric(name).encode(np.sort(log_value))
    assert (np.diff(encoded) >= 0.0).all()


def test_the_three_encodings_are_the_value_its_square_root_and_its_logarithm():
    log_value = np.log([0.25, 1.0, 9.0])
    assert error_metric("linear").encode(log_value) == pytest.approx([0.25, 1.0, 9.0])
    assert error_metric("root").encode(log_value) == pytest.approx([0.5, 1.0, 3.0])
    assert error_metric("log").encode(log_value) == pytest.approx(log_value)


@given(LOGS, st.floats(-3.0, 3.0))
def test_a_scale_factor_is_a_factor_or_a_constant_of_the_encoded_domain(log_value, log_factor):
    for metric in ERROR_METRICS.values():
        scaled = metric.encode(log_value + log_factor)
        if metric.needs_constant:
            assert np.allclose(scaled, metric.encode(log_value) + log_factor)
        else:
            assert np.allclose(scaled, metric.encode(log_value) * np.exp(metric.power * log_factor))


@given(NAMES, st.lists(st.floats(-1e30, 1e30), min_size=1, max_size=20).map(np.array))
def test_whatever_is_decoded_is_the_logarithm_of_a_positive_finite_value(name, encoded):
    for dtype in (np.float64, np.float32):
        log_value = error_metric(name).decode(encoded.astype(dtype))
        value = np.exp(log_value)
        assert np.isfinite(value).all()
        assert (value > 0.0).all()


def test_an_unknown_metric_is_refused_with_the_names_there_are():
    with pytest.raises(UsageError, match=r"'cubic'.*linear, root, log"):
        error_metric("cubic")
