"""The exposure and the sRGB curve."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.tone import display_image, exposure_scale, srgb_decode, srgb_encode, three_channels


def test_the_curve_and_its_inverse_meet():
    linear = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(srgb_decode(srgb_encode(linear)), linear, atol=1e-7)


def test_the_curve_passes_through_its_published_points():
    # IEC 61966-2-1: half of full light is code 188 of 255, 18 % grey code 118
    codes = np.rint(255 * srgb_encode(np.array([0.0, 0.18, 0.5, 1.0])))
    assert codes.tolist() == [0, 118, 188, 255]


def test_the_curve_clips_what_a_screen_cannot_show():
    assert srgb_encode(np.array([-1.0, 7.0])) == pytest.approx([0.0, 1.0])


def test_exposure_brings_the_95th_percentile_inside_the_mask_to_08(rng):
    image = rng.uniform(0.0, 3.0, (20, 20, 3))
    mask = np.zeros((20, 20), dtype=bool)
    mask[5:15, 5:15] = True
    image[~mask] = 1000.0
    scale = exposure_scale(image, mask)
    assert np.percentile(scale * image[mask], 95) == pytest.approx(0.8)


def test_a_display_image_is_grey_where_one_channel_is_given():
    shown = display_image(np.full((2, 2, 1), 0.25), 2.0)
    np.testing.assert_allclose(shown, srgb_encode(np.array(0.5)))
    assert shown.shape == (2, 2, 3)


def test_a_picture_of_31_channels_is_refused():
    with pytest.raises(UsageError, match="found 31 channels"):
        three_channels(np.ones((2, 2, 31)))


def test_loading_the_colour_library_leaves_the_print_options_of_numpy_alone():
    code = (
        "import numpy as np; before = np.get_printoptions(); import brdfit.tone as t; "
        "t.colour_library(); assert np.get_printoptions() == before"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
