"""The perceptual error: mean CIEDE2000 between two rendered spheres.

References: G. Sharma, W. Wu, E. N. Dalal, "The CIEDE2000 Color-Difference Formula:
Implementation Notes, Supplementary Test Data, and Mathematical Observations", Color Research
and Application 30(1), 2005; IEC 61966-2-1:1999.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.arrays import FloatArray
from brdfit.metrics.images import ImagePair
from brdfit.tone import colour_library

__all__ = ["difference_map", "lab_from_linear", "perceptual_error"]

# Linear sRGB to CIE XYZ (IEC 61966-2-1). Its row sums are the D65 white, so that grey has
# a* = b* = 0 exactly.
_XYZ_FROM_SRGB = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)


def perceptual_error(
    reference: npt.ArrayLike, test: npt.ArrayLike, mask: npt.ArrayLike | None = None
) -> float:
    """Return the mean CIEDE2000 of two linear images over the mask; 0 is identical.

    What "perceptual error", unqualified, means in brdfit, when the images are spheres of at
    least 64 x 64 pixels under the illumination `studio` and the mask is their disk.

    | name        | shape                      | unit and range                      |
    |-------------|----------------------------|-------------------------------------|
    | `reference` | (height, width, 1 or 3)    | linear sRGB, any scale; 1 = grey    |
    | `test`      | (height, width, 1 or 3)    | the same scale as the reference     |
    | `mask`      | (height, width) or None    | pixels that count; None = all       |

    Notes: both images are scaled by 0.8 / p95, p95 the 95th percentile of the reference's
    pixel values inside the mask (all channels together); clipped to [0, 1]; given the sRGB
    curve; compared in CIELAB under D65 with CIEDE2000 (kL = kC = kH = 1). CIELAB starts
    from linear light, so the sRGB curve is put on and taken off again: it cancels, and is
    left out. About 1 is a just noticeable difference of large patches side by side.
    Symmetric in the colours, not in the images: the reference sets the exposure.
    """
    return float(np.mean(_of_pixels(ImagePair.of(reference, test, mask))))


def difference_map(
    reference: npt.ArrayLike, test: npt.ArrayLike, mask: npt.ArrayLike | None = None
) -> FloatArray:
    """Return the CIEDE2000 (height, width) of every pixel, NaN outside the mask.

    Arguments and exposure are those of `perceptual_error`, which is the mean of this.
    """
    pair = ImagePair.of(reference, test, mask)
    found = np.full(pair.mask.shape, np.nan)
    found[pair.mask] = _of_pixels(pair)
    return found


def _of_pixels(pair: ImagePair) -> FloatArray:
    """Return the CIEDE2000 (n,) of the pixels inside the mask."""
    lab_reference, lab_test = (lab_from_linear(pixels) for pixels in pair.linear_pixels)
    difference = colour_library().difference.delta_E_CIE2000(lab_reference, lab_test)
    return np.asarray(difference, dtype=np.float64)


def lab_from_linear(linear: FloatArray) -> FloatArray:
    """Return CIELAB (..., 3) under D65 of linear sRGB (..., 3), clipped to [0, 1] first."""
    white = _XYZ_FROM_SRGB.sum(axis=1)
    xyz = np.clip(linear, 0.0, 1.0) @ _XYZ_FROM_SRGB.T
    lab = colour_library().XYZ_to_Lab(xyz, illuminant=white[:2] / white.sum())
    return np.asarray(lab, dtype=np.float64)
