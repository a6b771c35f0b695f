"""The perceptual error, pinned by a second implementation that shares no code with brdfit.

Everything below the line is written from the definition and the published equations with
loops and plain floats: its own sphere, lights, sRGB, CIELAB and CIEDE2000 (Sharma, Wu and
Dalal 2005).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from brdfit.errors import UsageError
from brdfit.metrics import difference_map, perceptual_error
from brdfit.render import Sphere, studio

RED = (0.30, 0.12, 0.05)
GLOSS = 40.0


class Matte:
    def evaluate(self, wi, wo):
        return np.broadcast_to(np.array(RED) / np.pi, (len(wi), 3))


class Glossy:
    def evaluate(self, wi, wo):
        half = wi + wo
        cosine = half[:, 2] / np.linalg.norm(half, axis=1)
        lobe = 0.3 * cosine**GLOSS
        return np.array(RED) * 1.15 / np.pi + lobe[:, None]


def test_the_perceptual_error_is_the_one_of_an_independent_implementation():
    sphere, light = Sphere(64), studio()
    matte, glossy = sphere.shade(Matte(), light), sphere.shade(Glossy(), light)
    expected, pixels = second_implementation(64)
    assert sphere.mask.sum() == pixels
    assert perceptual_error(matte, glossy, sphere.mask) == pytest.approx(expected, rel=2e-4)
    assert expected > 2.0


def test_the_perceptual_error_of_an_image_with_itself_is_zero(rng):
    image = rng.uniform(0.0, 2.0, (9, 9, 3))
    assert perceptual_error(image, image) == 0.0


def test_the_map_has_a_difference_for_every_pixel_and_their_mean_is_the_perceptual_error(rng):
    a, b = rng.uniform(0.1, 2.0, (2, 9, 9, 3))
    mask = rng.uniform(size=(9, 9)) < 0.6
    b[4, 4] = a[4, 4]
    mask[4, 4] = True
    found = difference_map(a, b, mask)
    np.testing.assert_array_equal(np.isfinite(found), mask)
    assert found[4, 4] == 0.0
    assert np.nanmean(found) == pytest.approx(perceptual_error(a, b, mask), rel=1e-12)


def test_scaling_both_images_together_changes_nothing(rng):
    a, b = rng.uniform(0.0, 2.0, (2, 9, 9, 3))
    assert perceptual_error(7.0 * a, 7.0 * b) == pytest.approx(perceptual_error(a, b))


def test_pixels_outside_the_mask_do_not_count(rng):
    a, b = rng.uniform(0.1, 2.0, (2, 9, 9, 3))
    mask = np.ones((9, 9), dtype=bool)
    mask[0] = False
    inside = perceptual_error(a, b, mask)
    a[0], b[0] = 100.0, np.nan
    assert perceptual_error(a, b, mask) == inside


def test_one_channel_is_grey_and_equals_three_equal_channels(rng):
    a, b = rng.uniform(0.1, 2.0, (2, 9, 9, 1))
    grey = perceptual_error(a, b)
    assert grey == pytest.approx(perceptual_error(np.repeat(a, 3, axis=2), np.repeat(b, 3, axis=2)))


def test_the_published_pairs_of_ciede2000_are_reproduced_by_both_implementations():
    # Sharma, Wu and Dalal 2005, table 1, pairs 1, 7, 15, 17 and 25
    from colour.difference import delta_E_CIE2000

    published = [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
        ((50.0, -0.001, 2.49), (50.0, 0.0011, -2.49), 4.7461),
        ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ]
    for first, second, expected in published:
        assert ciede2000(first, second) == pytest.approx(expected, abs=5e-5)
        assert float(delta_E_CIE2000(first, second)) == pytest.approx(expected, abs=5e-5)


def test_a_black_reference_is_an_error_that_says_so():
    with pytest.raises(UsageError, match="95th percentile of the reference image is 0"):
        perceptual_error(np.zeros((4, 4, 3)), np.ones((4, 4, 3)))


def test_pixels_that_are_not_finite_are_counted_in_the_error():
    image = np.ones((4, 4, 3))
    broken = image.copy()
    broken[1, 2, 0] = np.nan
    with pytest.raises(UsageError, match="1 of 16 pixels of the test are not finite"):
        perceptual_error(image, broken)


def test_images_of_different_sizes_are_refused_with_both_shapes():
    with pytest.raises(UsageError, match=r"\(4, 4, 3\) and \(5, 4, 3\)"):
        perceptual_error(np.ones((4, 4, 3)), np.ones((5, 4, 3)))


# ---------------------------------------------------------------------------------------------


def second_implementation(size: int) -> tuple[float, int]:
    lights = []
    for k in range(40):
        y = 1 - 2 * (k + 0.5) / 40
        ring = math.sqrt(1 - y * y)
        toward = (ring * math.cos(2.399963 * k), y, ring * math.sin(2.399963 * k))
        base = 0.15 * (1 + 0.5 * y)
        extra = (1.5, 1.4, 1.2) if k in (0, 18, 24, 29, 31) else (0, 0, 0)
        lights.append((toward, [base + e for e in extra]))
    matte, glossy = [], []
    for row in range(size):
        for column in range(size):
            x = (column + 0.5) / size * 2 - 1
            y = 1 - (row + 0.5) / size * 2
            if x * x + y * y >= 1:
                continue
            normal = (x, y, math.sqrt(1 - x * x - y * y))
            matte.append(pixel(normal, lights, glossy=False))
            glossy.append(pixel(normal, lights, glossy=True))
    values = sorted(v for p in matte for v in p)
    # linear interpolation between order statistics
    at = 0.95 * (len(values) - 1)
    low = int(at)
    p95 = values[low] + (at - low) * (values[min(low + 1, len(values) - 1)] - values[low])
    total = sum(
        ciede2000(lab_of(a, 0.8 / p95), lab_of(b, 0.8 / p95))
        for a, b in zip(matte, glossy, strict=True)
    )
    return total / len(matte), len(matte)


def pixel(normal, lights, glossy):
    out = [0.0, 0.0, 0.0]
    for toward, irradiance in lights:
        cosine = sum(n * t for n, t in zip(normal, toward, strict=True))
        if cosine <= 0:
            continue
        half = (toward[0], toward[1], toward[2] + 1.0)
        length = math.sqrt(sum(h * h for h in half))
        cos_h = sum(n * h for n, h in zip(normal, half, strict=True)) / length
        for c in range(3):
            f = RED[c] / math.pi
            if glossy:
                f = f * 1.15 + 0.3 * cos_h**GLOSS
            out[c] += f * irradiance[c] * cosine
    return out


def lab_of(linear, scale):
    encoded = []
    for value in linear:
        v = min(max(value * scale, 0.0), 1.0)
        encoded.append(12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055)
    r, g, b = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in encoded)
    xyz = (
        (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505,
        0.2126 * r + 0.7152 * g + 0.0722 * b,
        (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.0890,
    )
    f = [t ** (1 / 3) if t > (6 / 29) ** 3 else t / (3 * (6 / 29) ** 2) + 4 / 29 for t in xyz]
    return 116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])


def ciede2000(first, second):
    (l1, a1, b1), (l2, a2, b2) = first, second
    mean_c = (math.hypot(a1, b1) + math.hypot(a2, b2)) / 2
    g = 0.5 * (1 - math.sqrt(mean_c**7 / (mean_c**7 + 25**7)))
    a1, a2 = (1 + g) * a1, (1 + g) * a2
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    h1 = math.degrees(math.atan2(b1, a1)) % 360 if c1 else 0.0
    h2 = math.degrees(math.atan2(b2, a2)) % 360 if c2 else 0.0
    dl, dc, dh = l2 - l1, c2 - c1, h2 - h1
    if c1 * c2 == 0:
        dh = 0.0
    elif dh > 180:
        dh -= 360
    elif dh < -180:
        dh += 360
    dh = 2 * math.sqrt(c1 * c2) * math.sin(math.radians(dh) / 2)
    lm, cm, hm = (l1 + l2) / 2, (c1 + c2) / 2, h1 + h2
    if c1 * c2:
        if abs(h1 - h2) > 180:
            hm += 360 if hm < 360 else -360
        hm /= 2
    t = (
        1
        - 0.17 * math.cos(math.radians(hm - 30))
        + 0.24 * math.cos(math.radians(2 * hm))
        + 0.32 * math.cos(math.radians(3 * hm + 6))
        - 0.20 * math.cos(math.radians(4 * hm - 63))
    )
    sl = 1 + 0.015 * (lm - 50) ** 2 / math.sqrt(20 + (lm - 50) ** 2)
    sc, sh = 1 + 0.045 * cm, 1 + 0.015 * cm * t
    rotation = 30 * math.exp(-(((hm - 275) / 25) ** 2))
    rt = -math.sin(math.radians(2 * rotation)) * 2 * math.sqrt(cm**7 / (cm**7 + 25**7))
    return math.sqrt((dl / sl) ** 2 + (dc / sc) ** 2 + (dh / sh) ** 2 + rt * (dc / sc) * (dh / sh))
