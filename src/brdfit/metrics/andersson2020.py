"""FLIP: what one sees when two displayed images are flipped between.

Reference: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astrom,
M. D. Fairchild, "FLIP: A Difference Evaluator for Alternating Images", Proceedings of the ACM
on Computer Graphics and Interactive Techniques 3(2), 2020. Computed by flip-evaluator.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from brdfit.errors import MissingExtra
from brdfit.metrics.images import ImagePair

__all__ = ["flip"]


def flip(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    mask: npt.ArrayLike | None = None,
    *,
    pixels_per_degree: float = 67.0,
) -> float:
    """Return the mean LDR-FLIP in [0, 1] of two linear images; 0 is identical.

    | name                | shape                   | unit and range                       |
    |---------------------|-------------------------|--------------------------------------|
    | `reference`         | (height, width, 1 or 3) | linear sRGB, any scale               |
    | `test`              | (height, width, 1 or 3) | the same scale                       |
    | `mask`              | (height, width) or None | pixels that count; None = all        |
    | `pixels_per_degree` |                         | of visual angle, at the viewer's eye |

    Notes: exposed as for the perceptual error, clipped, sRGB-encoded; the mean of
    DeltaE_c^(1 - DeltaE_f) over the mask. 67 pixels a degree is a 0.7 m wide 3840-pixel
    screen seen from 0.7 m. Needs the extra `metrics`.
    """
    try:
        import flip_evaluator
    except ImportError as error:
        raise MissingExtra("flip-evaluator", "metrics", "FLIP") from error
    pair = ImagePair.of(reference, test, mask)
    a, b = (np.ascontiguousarray(image, dtype=np.float32) for image in pair.displayed)
    error_map, _, _ = flip_evaluator.evaluate(
        a,
        b,
        "LDR",
        applyMagma=False,
        computeMeanError=False,
        parameters={"ppd": pixels_per_degree},
    )
    return float(np.mean(np.asarray(error_map)[..., 0][pair.mask]))
