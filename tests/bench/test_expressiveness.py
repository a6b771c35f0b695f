"""The poster's test of its correction basis, on functions whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.bench.paper.expressiveness import Expressiveness


def functions(seed=0, n=600):
    """Return C of four materials in two channels; those of material 3 combine the others."""
    rng = np.random.default_rng(seed)
    values = 1.0 + 0.2 * rng.normal(size=(n, 8))
    values[:, 3] = 0.5 * values[:, 0] + 0.5 * values[:, 1]  # within its channel
    values[:, 7] = 0.3 * values[:, 0] + 0.7 * values[:, 4]  # across the channels only
    material = np.tile(np.arange(4), 2)
    return Expressiveness(values.astype(np.float32), material, rng.random(n) < 0.5, 2)


def test_what_the_others_of_a_channel_combine_has_no_deviation():
    found = functions()
    one_channel = Expressiveness(found.values[:, :4], found.material[:4], found.fitted, 1)
    assert one_channel.deviation(3) == pytest.approx(0.0, abs=1e-4)
    assert one_channel.deviation(2) > 0.1


def test_what_only_other_channels_tell_counts_with_all_channels_alone():
    assert functions().deviation_by_all(3) == pytest.approx(0.0, abs=1e-4)
    assert functions().deviation(3) > 0.02
