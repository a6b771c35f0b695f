"""Structural similarity of two displayed images.

Reference: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image Quality Assessment: From
Error Visibility to Structural Similarity", IEEE Transactions on Image Processing 13(4), 2004.
Computed by scikit-image.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.errors import MissingExtra, UsageError
from brdfit.metrics.images import ImagePair

__all__ = ["ssim"]

# 2 x int(3.5 sigma + 0.5) + 1 with sigma = 1.5
_WINDOW = 11


def ssim(reference: npt.ArrayLike, test: npt.ArrayLike, mask: npt.ArrayLike | None = None) -> float:
    """Return the mean SSIM in [-1, 1] of two linear images as a screen shows them; 1 = identical.

    | name        | shape                   | unit and range                 |
    |-------------|-------------------------|--------------------------------|
    | `reference` | (height, width, 1 or 3) | linear sRGB, any scale         |
    | `test`      | (height, width, 1 or 3) | the same scale                 |
    | `mask`      | (height, width) or None | pixels that count; None = all  |

    Notes: exposed as for the perceptual error, clipped, sRGB-encoded; Gaussian window of
    sigma 1.5 pixels, K1 = 0.01, K2 = 0.03, each channel by itself; the mean of the map over
    the mask and channels. Windows at the edge of the mask see what lies beyond it.
    Needs the extra `metrics`; images are at least 11 x 11 pixels.
    """
    try:
        from skimage.metrics import structural_similarity
    except ImportError as error:
        raise MissingExtra("scikit-image", "metrics", "SSIM") from error
    pair = ImagePair.of(reference, test, mask)
    a, b = pair.displayed
    if min(a.shape[:2]) < _WINDOW:
        raise UsageError(
            f"SSIM: the images are {a.shape[0]} x {a.shape[1]} pixels but its window is "
            f"{_WINDOW} pixels wide. Render larger."
        )
    _, similarity = structural_similarity(
        a,
        b,
        data_range=1.0,
        channel_axis=-1,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        full=True,
    )
    return float(np.mean(similarity[pair.mask]))
