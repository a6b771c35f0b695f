"""Laws that every image metric obeys, and figures that can be had by hand."""

from __future__ import annotations

import builtins

import numpy as np
import pytest

from brdfit.errors import MissingExtra, UsageError
from brdfit.metrics import METRICS, delta_e_itp, evaluate_metric, flip, psnr, ssim
from brdfit.tone import exposure_scale, srgb_encode

IMAGE_METRICS = [metric for metric in METRICS.values() if metric.compares == "images"]
PACKAGES = {"ssim": "skimage", "flip": "flip_evaluator"}

every_image_metric = pytest.mark.parametrize("metric", IMAGE_METRICS, ids=lambda m: m.name)


@pytest.fixture
def image(rng):
    smooth = np.linspace(0.05, 1.0, 24)
    return np.stack([np.outer(smooth, smooth[::-1]) + 0.1 * c for c in range(3)], axis=2)


def available(metric):
    if metric.extra:
        pytest.importorskip(PACKAGES[metric.name])
    return metric


@every_image_metric
def test_an_image_compared_with_itself_is_identical(metric, image):
    value = available(metric)(image, image)
    assert value == metric.identical or value == pytest.approx(metric.identical, abs=1e-6)


@every_image_metric
def test_a_larger_error_is_a_worse_value(metric, image):
    ramp = np.linspace(0.0, 1.0, 24)[:, None, None]
    little, much = image * (1.0 + 0.05 * ramp), image * (1.0 - 0.6 * ramp)
    a, b = available(metric)(image, little), metric(image, much)
    assert a > b if metric.higher_is_better else a < b


@every_image_metric
def test_the_scale_of_both_images_together_does_not_matter(metric, image, rng):
    test = image * rng.uniform(0.8, 1.2, image.shape)
    assert available(metric)(5.0 * image, 5.0 * test) == pytest.approx(
        metric(image, test), rel=1e-5
    )


@every_image_metric
def test_grey_of_one_channel_is_grey_of_three(metric, image):
    a, b = image[..., :1], 0.9 * image[..., :1]
    three = available(metric)(np.repeat(a, 3, axis=2), np.repeat(b, 3, axis=2))
    assert metric(a, b) == pytest.approx(three)


def test_psnr_is_minus_ten_log_of_the_mean_square_of_what_the_screen_shows(image):
    test = 0.7 * image
    scale = exposure_scale(image)
    error = np.mean((srgb_encode(image * scale) - srgb_encode(test * scale)) ** 2)
    assert psnr(image, test) == pytest.approx(-10 * np.log10(error))


def test_psnr_looks_at_the_mask_only(image):
    mask = np.zeros((24, 24), dtype=bool)
    mask[5:9, 5:9] = True
    test = image.copy()
    test[~mask] *= 3.0
    assert psnr(image, test, mask) == float("inf")


def test_delta_e_itp_is_that_of_the_recommendation_written_out():
    grey, brighter = np.full((4, 4, 3), 0.5), np.full((4, 4, 3), 0.6)
    # exposed: 0.8 and 0.96, at 203 cd/m^2; greys differ in I only, and I is PQ of luminance
    expected = 720 * abs(pq(0.8 * 203.0) - pq(0.96 * 203.0))
    assert delta_e_itp(grey, brighter) == pytest.approx(expected, rel=2e-3)


def test_delta_e_itp_still_sees_an_error_above_the_white_of_the_screen():
    reference = np.full((20, 20, 3), 0.5)
    reference[0, 0] = 5.0
    test = reference.copy()
    test[0, 0] = 10.0
    assert METRICS["perceptual_error"](reference, test) == 0.0
    assert delta_e_itp(reference, test) > 0.01


def test_a_missing_extra_is_named_with_the_command_that_installs_it(monkeypatch, image):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name.split(".")[0] in PACKAGES.values():
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    for metric in (ssim, flip):
        with pytest.raises(MissingExtra, match=r"pip install \"brdfit\[metrics\]\""):
            metric(image, image)


def test_ssim_of_a_tiny_image_says_how_large_it_must_be():
    pytest.importorskip("skimage")
    with pytest.raises(UsageError, match="4 x 4 pixels but its window is 11"):
        ssim(np.ones((4, 4, 3)), np.ones((4, 4, 3)))


def test_the_dispatcher_finds_metrics_by_name_and_lists_them_otherwise(image):
    assert evaluate_metric("psnr", image, 0.9 * image) == psnr(image, 0.9 * image)
    with pytest.raises(UsageError, match="found 'pnsr' but there are perceptual_error, "):
        evaluate_metric("pnsr", image, image)


def pq(luminance):
    # SMPTE ST 2084
    m1, m2, c1, c2, c3 = 0.1593017578125, 78.84375, 0.8359375, 18.8515625, 18.6875
    y = (luminance / 10_000.0) ** m1
    return ((c1 + c2 * y) / (1 + c3 * y)) ** m2
