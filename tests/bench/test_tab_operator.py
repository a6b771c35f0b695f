"""The shared interpolation weights say what the method's own interpolator says."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.bench.paper.tab_operator import TabOperator
from brdfit.reconstruct.coordinates import half_diff_features
from brdfit.reconstruct.tabulated import Tabulated


def features(rng, n):
    return half_diff_features(
        rng.uniform(0, 1.5, n), rng.uniform(0, 1.5, n), rng.uniform(0, np.pi, n)
    )


@pytest.mark.parametrize("kernel", ["linear", "thin_plate_spline", "cubic"])
def test_weights_and_interpolator_agree(kernel, rng):
    method = Tabulated(kernel=kernel, neighbors=20)
    samples, places = features(rng, 400), features(rng, 300)
    samples[1] = samples[0]
    values = rng.uniform(0.5, 2.0, (400, 3))
    expected = np.maximum(method.interpolator(samples, values)(places), 1e-6)
    assert np.allclose(TabOperator.build(method, samples, places).apply(values), expected, 1e-3)


def test_the_operator_is_exact_at_the_samples(rng):
    samples, values = features(rng, 200), rng.uniform(0.5, 2.0, (200, 1))
    operator = TabOperator.build(Tabulated(neighbors=30), samples, samples)
    assert np.allclose(operator.apply(values), values, rtol=1e-5)
