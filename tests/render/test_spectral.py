"""White stays white, grey stays grey, and colours come out as the CIE says."""

from __future__ import annotations

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.render import ForDisplay, display_matrix, rgb_matrix, shows_colour, to_rgb

# The library says that it samples D65 as finely as the observer: what is wanted here.
ALIGNS_D65 = pytest.mark.filterwarnings("ignore:Aligning")

BANDS_31 = np.arange(400.0, 701.0, 10.0)


@pytest.mark.parametrize(
    "wavelengths", [BANDS_31, [450.0, 550.0, 650.0], [351.0, 532.0, 633.0, 1064.0], [1064.0]]
)
def test_a_perfect_white_is_one_over_pi_in_red_green_and_blue(wavelengths):
    white = np.full(len(wavelengths), 1.0 / np.pi)
    np.testing.assert_allclose(to_rgb(white, wavelengths), 1.0 / np.pi, rtol=1e-12)


@ALIGNS_D65
def test_a_smooth_spectrum_has_the_colour_that_the_library_integrates():
    import colour

    values = 0.2 + 0.3 * np.exp(-(((BANDS_31 - 600.0) / 60.0) ** 2))
    spectrum = colour.SpectralDistribution(dict(zip(BANDS_31, values, strict=True)))
    fine = spectrum.copy().align(
        colour.SpectralShape(360, 830, 1),
        interpolator=colour.LinearInterpolator,
        extrapolator_kwargs={"method": "Constant"},
    )
    xyz = colour.sd_to_XYZ(fine, illuminant=colour.SDS_ILLUMINANTS["D65"]) / 100.0
    expected = colour.XYZ_to_sRGB(xyz, apply_cctf_encoding=False)
    np.testing.assert_allclose(to_rgb(values, BANDS_31), expected, atol=1.5e-3)
    assert expected[0] > 1.3 * expected[2]


def test_long_wavelengths_are_red_middle_ones_green_and_short_ones_blue():
    matrix = rgb_matrix(BANDS_31)
    assert [int(np.argmax(matrix[np.argmin(np.abs(BANDS_31 - nm))])) for nm in (610, 540, 450)] == [
        0,
        1,
        2,
    ]


def test_a_spectral_colour_outside_srgb_stays_negative():
    only_500 = (BANDS_31 == 500.0).astype(float)
    assert to_rgb(only_500, BANDS_31)[0] < 0.0


def test_the_order_of_the_bands_does_not_matter(rng):
    values, order = rng.uniform(0.1, 1.0, 31), rng.permutation(31)
    np.testing.assert_allclose(
        to_rgb(values[order], BANDS_31[order]), to_rgb(values, BANDS_31), rtol=1e-12
    )


def test_bands_outside_the_visible_contribute_nothing_even_when_missing():
    wavelengths = np.array([351.0, 442.0, 532.0, 633.0, 1064.0])
    values = np.array([np.nan, 0.1, 0.2, 0.3, np.nan])
    np.testing.assert_allclose(
        to_rgb(values, wavelengths), to_rgb(values[1:4], wavelengths[1:4]), rtol=1e-12
    )


def test_too_few_visible_bands_are_shown_as_the_grey_of_their_mean():
    laser_lines = [351.0, 532.0, 633.0, 1064.0]
    assert not shows_colour(laser_lines)
    np.testing.assert_allclose(to_rgb([9.0, 0.2, 0.4, 9.0], laser_lines), 0.3)
    assert display_matrix(4, laser_lines).shape == (4, 1)


def test_bands_far_apart_or_at_one_end_only_show_no_colour():
    assert shows_colour([450.0, 550.0, 650.0])
    assert not shows_colour([400.0, 420.0, 650.0])
    assert not shows_colour([600.0, 640.0, 680.0])
    assert not shows_colour([400.0, 420.0, 440.0])


def test_without_any_visible_band_the_nearest_to_555_nm_is_shown():
    np.testing.assert_allclose(to_rgb([0.7, 0.1], [1064.0, 1550.0]), 0.7)


def test_three_channels_without_wavelengths_are_red_green_and_blue_as_named():
    value = np.array([0.1, 0.2, 0.3])
    np.testing.assert_array_equal(to_rgb(value), value)
    np.testing.assert_array_equal(to_rgb(value, channels=("B", "R", "G")), [0.2, 0.3, 0.1])


def test_one_channel_is_grey_and_shape_is_kept(rng):
    values = rng.uniform(0.1, 1.0, (4, 5, 1))
    np.testing.assert_array_equal(to_rgb(values), np.repeat(values, 3, axis=2))
    np.testing.assert_allclose(to_rgb([0.2, 0.6]), 0.4)


def test_a_brdf_of_31_bands_is_shaded_in_three_channels():
    class Bands:
        def evaluate(self, wi, wo):
            return np.full((len(wi), 31), 1.0 / np.pi)

    up = np.array([[0.0, 0.0, 1.0]])
    shown = ForDisplay.of(Bands(), BANDS_31)
    np.testing.assert_allclose(shown.evaluate(up, up), 1.0 / np.pi)
    assert shown.evaluate(up, up).shape == (1, 3)


def test_a_wrong_number_of_wavelengths_is_refused():
    with pytest.raises(UsageError, match="found 3 but the values have 4 channels"):
        to_rgb(np.ones(4), [450.0, 550.0, 650.0])
