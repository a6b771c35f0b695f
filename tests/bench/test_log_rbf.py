"""The log-domain RBF rival interpolates, obeys reciprocity, and survives odd input."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.bench.log_rbf import LogRbf
from brdfit.geometry import half_diff_from_directions
from brdfit.samples import Samples


def smooth(wi, wo):
    theta_h, theta_d, _ = half_diff_from_directions(wi, wo)
    value = 0.1 + np.exp(-((theta_h / 0.4) ** 2)) * (1 + theta_d)
    return np.stack([value, 0.5 * value], axis=1)


@pytest.fixture
def samples(random_directions):
    wi, wo = random_directions(300)
    return Samples(wi=wi, wo=wo, value=smooth(wi, wo))


def test_a_smooth_material_is_predicted_where_it_was_not_measured(samples, random_directions):
    wi, wo = random_directions(200)
    error = np.abs(np.log(LogRbf.fit(samples).evaluate(wi, wo) / smooth(wi, wo)))
    assert np.median(error) < 0.03


def test_light_and_detector_may_be_exchanged(samples, random_directions):
    fitted, (wi, wo) = LogRbf.fit(samples), random_directions(50)
    assert np.allclose(fitted.evaluate(wi, wo), fitted.evaluate(wo, wi), rtol=1e-6)


def test_repeated_directions_and_missing_values_are_borne(samples):
    value = np.vstack([samples.value, samples.value * 1.1])
    value[3, 0], value[4, 1], value[5] = np.nan, 0.0, -1.0
    doubled = Samples(
        wi=np.vstack([samples.wi, samples.wo]), wo=np.vstack([samples.wo, samples.wi]), value=value
    )
    assert np.isfinite(LogRbf.fit(doubled).evaluate(samples.wi, samples.wo)).all()


def test_samples_in_one_plane_are_enough(samples):
    flat_wi = samples.wi * [1.0, 0.0, 1.0]
    flat_wo = samples.wo * [1.0, 0.0, 1.0]
    flat_wi /= np.linalg.norm(flat_wi, axis=1, keepdims=True)
    flat_wo /= np.linalg.norm(flat_wo, axis=1, keepdims=True)
    plane = Samples(wi=flat_wi, wo=flat_wo, value=smooth(flat_wi, flat_wo))
    error = np.abs(np.log(LogRbf.fit(plane).evaluate(flat_wi, flat_wo) / plane.value))
    assert np.median(error) < 0.03


def test_three_samples_give_their_mean(samples):
    three = samples.subset([0, 1, 2])
    expected = np.exp(np.log(three.value).mean(axis=0))
    assert np.allclose(LogRbf.fit(three).evaluate(samples.wi, samples.wo), expected)


def test_a_channel_without_a_positive_value_predicts_nothing(samples):
    value = samples.value.copy()
    value[:, 1] = 0.0
    fitted = LogRbf.fit(samples.with_value(value)).evaluate(samples.wi, samples.wo)
    assert np.isnan(fitted[:, 1]).all()
    assert np.isfinite(fitted[:, 0]).all()
