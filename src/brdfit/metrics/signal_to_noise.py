"""Peak signal-to-noise ratio of two displayed images.

Reference: Recommendation ITU-T J.340 (2010), "Reference algorithm for computing peak signal to
noise ratio", taken here for one colour image.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.metrics.images import ImagePair

__all__ = ["psnr"]


def psnr(reference: npt.ArrayLike, test: npt.ArrayLike, mask: npt.ArrayLike | None = None) -> float:
    """Return the PSNR in dB of two linear images as a screen shows them; infinite if identical.

    | name        | shape                   | unit and range                 |
    |-------------|-------------------------|--------------------------------|
    | `reference` | (height, width, 1 or 3) | linear sRGB, any scale         |
    | `test`      | (height, width, 1 or 3) | the same scale                 |
    | `mask`      | (height, width) or None | pixels that count; None = all  |

    Notes: exposed as for the perceptual error, clipped, sRGB-encoded to v in [0, 1]; then
    -10 log10(mean (v_test - v_reference)^2) over pixels and channels. Higher is better.
    """
    pair = ImagePair.of(reference, test, mask)
    a, b = pair.displayed
    error = float(np.mean((a[pair.mask] - b[pair.mask]) ** 2))
    return float("inf") if error == 0.0 else -10.0 * float(np.log10(error))
